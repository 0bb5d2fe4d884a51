from pathlib import Path

import numpy as np
import pytest

from conf.cli import main
from conf.mesh_fitting.fit import FitReport


def test_the_points_are_written_beside_the_mesh(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def fit(face: Path, output: Path, *, up: str | None, front: str | None, on_progress: object) -> FitReport:
        assert (up, front) == ("z", "-y")
        return FitReport(str(face), str(output), "z", "-y", 6.4, 3, 4, 2, True, ())

    monkeypatch.setattr("conf.mesh_fitting.fit.fit", fit)
    with pytest.raises(SystemExit) as exit_:
        main(["fit", "a/face.obj", "--up", "z", "--front=-y", "--json"])
    assert exit_.value.code == 0 and f'"output": "{Path("a/face.ppc")}"' in capsys.readouterr().out


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("face.txt", "must end in one of"),
        ("no/face.png", "cannot be written (No such file or directory); choose another"),
    ],
)
def test_the_picture_is_checked_before_the_fit(name: str, expected: str, tmp_path: Path) -> None:
    with pytest.raises(SystemExit) as exit_:
        main(["fit", "a/face.obj", "--picture", str(tmp_path / name)])
    assert expected in str(exit_.value.code)


def test_the_picture_is_drawn_from_the_points_found(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    def draw(face: Path, points: Path) -> np.ndarray:
        assert (face, points) == (Path("a/face.obj"), Path("b/face.ppc"))
        return np.zeros((4, 4, 3), np.uint8)

    report = FitReport("a/face.obj", "b/face.ppc", "y", "z", 6.4, 3, 4, 2, True, ())
    monkeypatch.setattr("conf.mesh_fitting.fit.fit", lambda *paths, **options: report)
    monkeypatch.setattr("conf.mesh_fitting.expression_sheet.draw_fitted_face", draw)
    with pytest.raises(SystemExit) as exit_:
        main(["fit", "a/face.obj", "-o", "b/face.ppc", "--picture", str(tmp_path / "face.png")])
    assert exit_.value.code == 0 and (tmp_path / "face.png").exists()
    assert "face.png" in "".join(capsys.readouterr().out.split())
