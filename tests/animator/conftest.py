"""Fixtures: the shipped head as a document and a model, a mesh file without control points, a controller, a panel."""

from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

from conf.animator.controller import Controller
from conf.animator.face_document import FaceDocument, open_face_document
from conf.animator.gui.main import Panel
from conf.animator.state.editor import EditorState
from conf.face.deformation.face_model import DeformerOptions, FaceModel
from conf.output.obj_writer import write_obj
from tests.support.imgui_stage import Stage, stage

__all__ = ["stage"]

FILE_SCALE, FILE_OFFSET = 25.0, np.array([3.0, 1500.0, -8.0])  # model centimetres to the unit of `unplaced_mesh`
NOW = 1.0  # seconds, when a panel is drawn


@pytest.fixture(scope="session")
def document() -> FaceDocument:
    """The shipped head."""
    return open_face_document()


@pytest.fixture(scope="session")
def points(document: FaceDocument) -> np.ndarray:
    """The shipped head's (n, 3) control points."""
    assert document.points is not None
    return document.points


@pytest.fixture(scope="session")
def head(document: FaceDocument) -> FaceModel:
    """The shipped head's model."""
    return document.operator_builder().build_face(DeformerOptions())


@pytest.fixture(scope="session")
def unplaced_mesh(document: FaceDocument, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The shipped head as a mesh file in another unit, without control points."""
    path = tmp_path_factory.mktemp("unplaced") / "unplaced.obj"
    write_obj(path, document.mesh, document.mesh.vertices * FILE_SCALE + FILE_OFFSET)
    return path


@pytest.fixture
def controller(stage: Stage, document: FaceDocument) -> Iterator[Controller]:
    """A controller of the shipped head."""
    controller = Controller(stage.window.ctx, document)
    yield controller
    controller.release()


class PanelDriver:
    """A panel and its controller; presses widgets by their labels."""

    def __init__(self, stage: Stage, panel: Panel, controller: Controller, monkeypatch: pytest.MonkeyPatch) -> None:
        self.controller = controller
        self._stage, self._panel, self._monkeypatch = stage, panel, monkeypatch
        self.draw()

    @property
    def state(self) -> EditorState:
        return self.controller.state

    def draw(self) -> None:
        self._stage.frame(self._draw)

    def labels(self) -> set[str]:
        return set(self._stage.widgets(self._draw, self._monkeypatch))

    def press(self, label: str) -> None:
        """Click at the centre of a widget."""
        centre = self._stage.find(label, self._draw, self._monkeypatch)
        self._stage.click(*centre, self._draw)

    def _draw(self) -> None:
        self._panel(self.controller, NOW)


@pytest.fixture
def open_panel(stage: Stage, controller: Controller, monkeypatch: pytest.MonkeyPatch) -> Callable[[Panel], PanelDriver]:
    """Draw a panel for the shipped head."""
    return lambda panel: PanelDriver(stage, panel, controller, monkeypatch)
