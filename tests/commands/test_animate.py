from pathlib import Path

import numpy as np
import pytest

from conf.animator.background_fit import Axes
from conf.commands.animate import animate, fit_points
from conf.errors import ConfError, FileFormatError
from conf.face.fitting.point_fitting import FittedPoints


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
    found = fit_points(Path("a.obj"), ("z", None), lambda text: None)
    assert found.points is points
    assert found.remarks == ("check the lids",)
