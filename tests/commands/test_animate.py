from pathlib import Path

import numpy as np
import pytest

from conf.commands.animate import FaceOptions, animate, fit_points
from conf.errors import ConfError, FileFormatError
from conf.face.formats.ppc import write_ppc
from conf.mesh_fitting.fit import FitReport


def test_wrong_arguments_are_errors_before_a_window_opens(tmp_path: Path) -> None:
    with pytest.raises(ConfError, match="there is no emotion 'glee': choose one of joy"):
        animate(FaceOptions(), emotion="glee")
    with pytest.raises(FileFormatError, match=r"nowhere\.obj"):
        animate(FaceOptions(tmp_path / "nowhere.obj"))


def test_points_are_found_as_by_conf_fit(monkeypatch: pytest.MonkeyPatch) -> None:
    points = np.random.default_rng(1).normal(size=(50, 3))

    def fit(face: Path, output: Path, *, up: str | None, front: str | None, on_progress: object) -> FitReport:
        assert (face, up, front) == (Path("a.obj"), "z", None)
        write_ppc(output, points)
        return FitReport(str(face), str(output), "z", "-y", 6.4, 3, 4, 2, True, ("check the lids",))

    monkeypatch.setattr("conf.mesh_fitting.fit.fit", fit)
    found = fit_points(Path("a.obj"), ("z", None), lambda text: None)
    np.testing.assert_allclose(found.points, points, atol=1e-5)
    assert found.remarks == ("check the lids",)
