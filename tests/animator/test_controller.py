from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from conf.animator.background_fit import FitResult
from conf.animator.commands import (
    Export,
    OpenFile,
    PlacePoints,
    PlayExpression,
    SavePoints,
    SetAxes,
    ToggleMotionRecording,
)
from conf.animator.controller import Controller
from conf.animator.face_document import FaceDocument
from conf.animator.face_instance import FaceInstance
from conf.animator.motion_mixer import MotionSample
from conf.animator.motion_player import REST_POSE
from conf.face.animation.action_units import load_emotions
from conf.face.deformation.face_model import DeformerOptions
from conf.face.formats.epc import ExpressionSet, write_epc
from conf.face.mesh.mesh import load_mesh
from tests.animator.conftest import TO_FILE
from tests.support.imgui_stage import Stage


@pytest.fixture
def director(stage: Stage, subject: FaceDocument) -> Iterator[Controller]:
    director = Controller(stage.window.ctx, FaceInstance(stage.window.ctx, subject, DeformerOptions()))
    yield director
    director.release()


def test_a_file_of_expressions_adds_buttons(director: Controller, tmp_path: Path) -> None:
    write_epc(tmp_path / "mine.epc", ExpressionSet(("bliss", "joy"), np.stack([load_emotions()["joy"]] * 2)))
    director.handle(OpenFile(tmp_path / "mine.epc"), 0.0)
    assert set(director.emotions.names) == {*load_emotions().names, "bliss"}
    director.handle(PlayExpression("bliss"), 1.0)
    assert director.desk.expressing.active(1.0) == "bliss"


def test_what_cannot_be_opened_becomes_a_notice(director: Controller, tmp_path: Path) -> None:
    director.handle(OpenFile(tmp_path / "a.doc"), 0.0)
    assert "open a mesh (.obj, .ply, .glb, .stl), a .ppc, a .dpc or an .epc file" in director.notice
    director.handle(OpenFile(tmp_path / "none.dpc"), 0.0)
    assert "none.dpc" in director.notice
    director.handle(SavePoints(tmp_path / "no" / "a.ppc"), 0.0)
    assert "cannot be written" in director.notice


def test_another_face_takes_the_stage_with_no_points(director: Controller, stranger: Path) -> None:
    director.handle(OpenFile(stranger), 0.0)
    assert director.actor.subject.points is None
    director.handle(PlacePoints(), 0.0)
    assert director.desk.placing is not None and director.desk.placing.missing == 50


def test_missing_points_are_found_unless_they_are_placed_by_hand_meanwhile(
    stage: Stage, subject: FaceDocument, stranger: Path
) -> None:
    scale, shift = TO_FILE
    assert subject.points is not None
    truth = subject.points * scale + shift

    def fit(path: Path, axes: tuple[str | None, str | None], on_progress: Callable[[str], None]) -> FitResult:
        return FitResult(truth, ("check the lids",))

    def settled(director: Controller) -> None:
        while director.fitting.progress is not None:
            director.update()

    director = Controller(stage.window.ctx, FaceInstance(stage.window.ctx, subject, DeformerOptions()), fit)
    director.handle(OpenFile(stranger), 0.0)
    director.handle(PlacePoints(), 0.0)
    settled(director)
    assert director.actor.subject.points is None and director.desk.placing is not None
    director.handle(SetAxes("y", "z"), 0.0)
    director.find_missing_points()
    settled(director)
    np.testing.assert_allclose(director.actor.subject.points, subject.points, atol=2e-3)
    assert director.notice.endswith("Save PPC keeps them. check the lids")
    director.release()


def test_a_take_becomes_the_recording(director: Controller) -> None:
    director.handle(ToggleMotionRecording(), 0.0)
    assert director.recorder is not None
    for i in range(10):
        director.recorder.add(np.full((50, 3), i, np.float32), REST_POSE.to_vector(), i / 20)
    director.handle(ToggleMotionRecording(), 1.0)
    assert director.recorder is None and director.player is not None
    assert director.player.recording.duration == pytest.approx(0.45, abs=0.04)


def test_what_is_shown_is_written(director: Controller, tmp_path: Path) -> None:
    vertices = director.actor.face.deform(load_emotions()["joy"])
    director.last_frame = (vertices, MotionSample(load_emotions()["joy"], REST_POSE))
    director.desk = replace(director.desk, fields=replace(director.desk.fields, output=str(tmp_path / "a.obj")))
    director.handle(Export(), 0.0)
    np.testing.assert_allclose(load_mesh(tmp_path / "a.obj").vertices, vertices, atol=1e-4)
