from pathlib import Path

import numpy as np
import pytest

from conf.animator.background_fit import Axes
from conf.animator.controller import Controller
from conf.animator.face_document import open_face_document
from conf.commands.animate import animate, fit_points, show_emotion
from conf.errors import ConfError, FileFormatError
from conf.face.animation.action_units import load_emotions
from conf.face.fitting.point_fitting import FittedPoints
from conf.face.formats.epc import ExpressionSet, write_epc
from tests.support.imgui_stage import Stage, stage

__all__ = ["stage"]


@pytest.mark.slow
def test_wrong_arguments_are_errors_before_a_window_opens(tmp_path: Path) -> None:
    with pytest.raises(ConfError, match="there is no emotion 'glee': choose one of joy"):
        animate(emotion="glee")
    with pytest.raises(FileFormatError, match=r"nowhere\.obj"):
        animate(tmp_path / "nowhere.obj")


def test_points_are_found_as_by_conf_fit(monkeypatch: pytest.MonkeyPatch) -> None:
    points = np.random.default_rng(1).normal(size=(50, 3))

    def find(path: Path, axes: Axes, _: object) -> tuple[FittedPoints, tuple[str, str], tuple[str, ...]]:
        assert (path, axes) == (Path("a.obj"), ("z", None))
        return FittedPoints(points, 3, 4, 2, True), ("z", "-y"), ("check the lids",)

    monkeypatch.setattr("conf.mesh_fitting.fit.find_points", find)
    found = fit_points(Path("a.obj"), ("z", None), lambda fraction, text: None)
    assert found.points is points
    assert found.remarks == ("check the lids",)


@pytest.mark.slow
def test_a_file_is_played_though_its_expression_is_called_as_a_built_in_one(stage: Stage, tmp_path: Path) -> None:
    own = np.zeros((1, 50, 3), np.float32)
    own[0, 3, 1] = 250.0
    write_epc(tmp_path / "own.epc", ExpressionSet(("joy",), own))
    controller = Controller(stage.window.ctx, open_face_document())
    show_emotion(controller, "joy", 0.0)
    assert controller.state.expression.hold_until_released
    np.testing.assert_array_equal(controller.expressions["joy"], load_emotions()["joy"])
    show_emotion(controller, str(tmp_path / "own.epc"), 0.0)
    np.testing.assert_allclose(controller.expressions["joy"], own[0])
    np.testing.assert_allclose(controller.state.expression.running[-1].displacements, own[0])
    controller.release()
