from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from conf.animator.background_fit import Axes, FitResult
from conf.animator.controller import Controller
from conf.animator.face_document import FaceDocument, open_face_document
from conf.animator.file_dialog import NOT_AVAILABLE, FileDialog, FileRequest
from conf.animator.motion_player import REST_POSE
from conf.face.animation.action_units import load_emotions
from conf.face.formats.dpc import MotionClip, write_dpc
from conf.face.formats.epc import ExpressionSet, write_epc
from conf.face.formats.ppc import read_ppc, write_ppc
from conf.face.mesh.mesh import load_mesh
from conf.sender.capture.clip import open_clip
from tests.animator.conftest import FILE_OFFSET, FILE_SCALE, NOW
from tests.support.imgui_stage import Stage

pytestmark = pytest.mark.slow

JOY = load_emotions()["joy"]


def test_an_expression_file_adds_its_expressions(controller: Controller, tmp_path: Path) -> None:
    write_epc(tmp_path / "mine.epc", ExpressionSet(("bliss", "joy"), np.stack([JOY] * 2)))
    controller.open_file(tmp_path / "mine.epc", NOW)
    assert set(controller.expressions.names) == {*load_emotions().names, "bliss"}
    controller.play_expression("bliss", NOW)
    assert controller.state.expression.active(NOW) == "bliss"
    assert controller.state.expression.running[0].displacements == pytest.approx(JOY, abs=1e-2)


def test_a_recording_is_opened_and_played(controller: Controller, tmp_path: Path) -> None:
    values = np.zeros((11, 50, 3), np.float32)
    values[:, 0, 1] = -300
    write_dpc(tmp_path / "a.dpc", MotionClip(10.0, "fapu", values))
    controller.open_file(tmp_path / "a.dpc", NOW)
    assert controller.player is not None and controller.player.is_playing(NOW)
    assert controller.notice == "opened a.dpc"
    vertices, sample = controller.deform(NOW)
    assert sample.displacements[0, 1] == -300 and (vertices != controller.face.model.neutral).any()


def test_errors_become_notices(controller: Controller, tmp_path: Path) -> None:
    controller.open_file(tmp_path / "a.doc", NOW)
    assert "open a mesh (.obj, .ply, .glb, .vrm, .gltf, .stl), a .ppc, a .dpc or an .epc file" in controller.notice
    controller.open_file(tmp_path / "none.dpc", NOW)
    assert "none.dpc" in controller.notice
    controller.save_points(tmp_path / "no" / "a.ppc")
    assert "cannot be written" in controller.notice


def test_a_mesh_without_points_is_placed_from_nothing(controller: Controller, unplaced_mesh: Path) -> None:
    controller.open_file(unplaced_mesh, NOW)
    assert controller.face.document.points is None
    controller.place_points()
    assert controller.state.placement is not None and controller.state.placement.missing == 50
    vertices, _ = controller.deform(NOW)
    assert vertices is controller.face.model.neutral


def test_placed_points_rebuild_the_face(controller: Controller, points: np.ndarray, tmp_path: Path) -> None:
    controller.place_points()
    placement = controller.state.placement
    assert placement is not None
    controller.state = replace(controller.state, placement=placement.set_point(0, points[0] + 0.1))
    controller.apply_points()
    assert controller.state.placement is None
    controller.save_points(tmp_path / "a.ppc")
    assert controller.notice == f"saved {tmp_path / 'a.ppc'}"
    np.testing.assert_allclose(read_ppc(tmp_path / "a.ppc")[0], points[0] + 0.1, atol=1e-5)


def test_missing_points_are_found_unless_points_are_being_placed(
    stage: Stage, unplaced_mesh: Path, points: np.ndarray
) -> None:
    def fit(path: Path, axes: Axes, on_progress: Callable[[float, str], None]) -> FitResult:
        return FitResult(points * FILE_SCALE + FILE_OFFSET, ("check the lids",))

    def wait_for_fit() -> None:
        while controller.fitting.progress is not None:
            controller.update(NOW)

    controller = Controller(stage.window.ctx, open_face_document(unplaced_mesh), fit)
    controller.place_points()
    wait_for_fit()
    assert controller.face.document.points is None and controller.state.placement is not None
    controller.set_axes("y", "z")
    controller.find_missing_points()
    wait_for_fit()
    found = controller.face.document.points
    assert found is not None
    np.testing.assert_allclose(found, points, atol=2e-3)
    assert controller.notice.endswith("Save PPC saves them. check the lids")
    controller.release()


def test_recorded_motion_becomes_the_recording(controller: Controller) -> None:
    controller.toggle_recorder(0.0)
    assert controller.recorder is not None
    for i in range(10):
        controller.deform(i / 20)
    controller.toggle_recorder(1.0)
    assert controller.recorder is None and controller.player is not None
    assert controller.player.duration == pytest.approx(0.45, abs=0.04)


def test_muscles_and_expressions_deform_the_face(controller: Controller) -> None:
    expression = replace(controller.state.expression, idle=False)  # no random blink at the compared moment
    muscles = controller.state.muscles.with_preset("smile")
    controller.state = replace(controller.state, muscles=muscles, expression=expression)
    while np.abs(controller.deform(NOW)[0] - controller.face.model.neutral).max() < 0.3:
        controller.update(NOW)
    controller.play_expression("joy", NOW)
    assert not controller.state.muscles.active
    _, sample = controller.deform(NOW + 1)
    assert np.abs(sample.displacements - JOY).max() < np.abs(JOY).max() / 2


def test_the_current_view_is_exported_and_saved_as_screenshot(controller: Controller, tmp_path: Path) -> None:
    controller.play_expression("joy", 0.0)
    vertices, _ = controller.deform(1.0)
    fields = replace(controller.state.fields, output=str(tmp_path / "a.obj"), size="64x48")
    controller.state = replace(controller.state, fields=fields)
    controller.export()
    np.testing.assert_allclose(load_mesh(tmp_path / "a.obj").vertices, vertices, atol=1e-4)
    controller.save_screenshot(tmp_path)
    assert controller.notice == f"saved {tmp_path / 'conf-001.jpg'}" and (tmp_path / "conf-001.jpg").exists()
    assert controller.state.fields == fields


def start_clip(controller: Controller, path: Path) -> None:
    """Start to export joy as a clip, and write some of its frames."""
    fields = replace(controller.state.fields, output=str(path), size="64x48", source="joy")
    controller.state = replace(controller.state, fields=fields)
    controller.export()
    for i in range(5):
        controller.update(NOW + i / 60)


def test_an_exported_clip_is_reported_with_its_full_path(
    controller: Controller, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    start_clip(controller, Path("a.mp4"))
    while controller.export_progress is not None:
        controller.update(NOW)
    assert controller.notice == f"saved {tmp_path / 'a.mp4'}" and controller.reports == [controller.notice]
    with open_clip(tmp_path / "a.mp4") as clip:
        assert len(list(iter(clip.read, None))) > 30


def test_a_cancelled_export_keeps_the_old_clip_and_names_the_frames_so_far(
    controller: Controller, tmp_path: Path
) -> None:
    (tmp_path / "a.mp4").write_bytes(b"old")
    start_clip(controller, tmp_path / "a.mp4")
    controller.cancel_export()
    kept = f"{tmp_path / 'a.mp4'} is as it was before; what was written so far is in {tmp_path / 'a.partial.mp4'}"
    assert controller.notice == f"export cancelled; {kept}" and not controller.reports
    assert (tmp_path / "a.mp4").read_bytes() == b"old"
    with open_clip(tmp_path / "a.partial.mp4") as clip:
        assert len(list(iter(clip.read, None))) == 5


def test_a_motion_format_cannot_hold_the_current_view(controller: Controller, tmp_path: Path) -> None:
    for name, kind in (("a.mp4", "clips"), ("a.dpc", "motion files")):
        fields = replace(controller.state.fields, output=str(tmp_path / name))
        controller.state = replace(controller.state, fields=fields)
        controller.export()
        assert f"{kind} need a motion" in controller.notice


def test_finished_expressions_are_removed_and_idle_motion_remains(controller: Controller) -> None:
    controller.play_expression("joy", 0.0)
    controller.update(20.0)
    assert controller.state.expression.running == ()
    assert controller.deform(20.0)[1].pose is not REST_POSE


class Chosen:
    """A dialog in which a file was chosen."""

    def __init__(self, path: Path) -> None:
        self._path = path

    def ready(self, _timeout: int) -> bool:
        return True

    def result(self) -> str:
        return str(self._path)

    def kill(self) -> bool:
        return True


def test_a_file_chosen_in_a_dialog_is_used_at_once(
    stage: Stage, document: FaceDocument, points: np.ndarray, tmp_path: Path
) -> None:
    requests: list[FileRequest] = []
    answers = {
        "points": tmp_path / "a.ppc",
        "saved points": tmp_path / "b.ppc",
        "output": tmp_path / "c.mp4",
        "face": tmp_path / "none.obj",
    }

    def open_dialog(request: FileRequest) -> Chosen:
        requests.append(request)
        return Chosen(answers[request.purpose])

    write_ppc(tmp_path / "a.ppc", points + 0.2)
    dialog = FileDialog(is_available=lambda: True, open_dialog=open_dialog)
    controller = Controller(stage.window.ctx, document, file_dialog=dialog)
    for field in answers:
        controller.choose_file(field)
        controller.update(NOW)
    assert controller.face.document.points == pytest.approx(points + 0.2, abs=1e-4)
    np.testing.assert_allclose(read_ppc(tmp_path / "b.ppc"), points + 0.2, atol=1e-4)
    fields = controller.state.fields
    assert (fields.points, fields.output) == (str(tmp_path / "b.ppc"), str(tmp_path / "c.mp4"))
    assert "none.obj" in controller.notice
    assert [request.save for request in requests] == [False, True, True, False]
    assert requests[0].start == Path.cwd(), "the shipped head's folder belongs to the program"
    assert requests[1].start == tmp_path / "a.ppc"
    controller.release()


def test_without_dialogs_the_user_reads_to_type_the_path(stage: Stage, document: FaceDocument) -> None:
    controller = Controller(stage.window.ctx, document, file_dialog=FileDialog(is_available=lambda: False))
    controller.choose_file("face")
    controller.update(NOW)
    assert controller.notice == NOT_AVAILABLE
    controller.release()


def test_points_are_saved_beside_a_mesh_but_not_beside_the_shipped_head(
    controller: Controller, unplaced_mesh: Path
) -> None:
    assert controller.points_path == Path("head.ppc")
    controller.open_file(unplaced_mesh, NOW)
    assert controller.points_path == unplaced_mesh.with_suffix(".ppc")
    controller.state = replace(controller.state, fields=replace(controller.state.fields, points=" ~/a.ppc "))
    assert controller.points_path == Path("~/a.ppc").expanduser()
    controller.open_file(unplaced_mesh, NOW)
    assert controller.points_path == unplaced_mesh.with_suffix(".ppc"), "not the file of the face before"
