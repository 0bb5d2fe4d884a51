"""The shipped head as a subject, and a mesh file that nobody knows the control points of."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from conf.animator.commands import Request
from conf.animator.face_document import FaceDocument, open_face_document
from conf.animator.gui.main import Panel
from conf.animator.state.editor import EditorState, StatusInfo
from conf.face.animation.action_units import load_emotions
from conf.face.deformation.face_model import DeformerOptions, FaceModel
from conf.output.obj_writer import write_obj
from tests.support.imgui_stage import Stage, stage

__all__ = ["stage"]

TO_FILE = (25.0, np.array([3.0, 1500.0, -8.0]))  # scale and shift of the stranger's file


@pytest.fixture(scope="session")
def subject() -> FaceDocument:
    """The shipped head."""
    return open_face_document()


@pytest.fixture(scope="session")
def head(subject: FaceDocument) -> FaceModel:
    """The shipped head's model."""
    return subject.operator_builder().build_face(DeformerOptions())


@pytest.fixture(scope="session")
def stranger(subject: FaceDocument, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The shipped head as a mesh file of another unit, without control points."""
    path = tmp_path_factory.mktemp("stranger") / "stranger.obj"
    scale, shift = TO_FILE
    write_obj(path, subject.mesh, subject.mesh.vertices * scale + shift)
    return path


class Worked:
    """A panel with the desk it works on: click its widgets by their labels."""

    def __init__(self, stage: Stage, panel: Panel, facts: StatusInfo, monkeypatch: pytest.MonkeyPatch) -> None:
        self.desk, self.facts, self.requests = EditorState(), facts, list[Request]()
        self._stage, self._panel, self._monkeypatch = stage, panel, monkeypatch
        self._draw()

    def _draw(self) -> None:
        self._stage.frame(self._once)

    def _once(self) -> None:
        self.desk, asked = self._panel(self.desk, self.facts)
        self.requests += asked

    def press(self, label: str) -> None:
        """Click in the middle of a widget."""
        place = self._stage.find(label, self._once, self._monkeypatch)
        self._stage.click(*place, self._once)


@pytest.fixture
def facts(subject: FaceDocument) -> StatusInfo:
    """What panels are told of the shipped head."""
    return StatusInfo(1.0, subject, None, load_emotions(), vertices=len(subject.mesh.vertices))


@pytest.fixture
def work(stage: Stage, facts: StatusInfo, monkeypatch: pytest.MonkeyPatch) -> Callable[[Panel], Worked]:
    """Open a panel to work on."""
    return lambda panel: Worked(stage, panel, facts, monkeypatch)
