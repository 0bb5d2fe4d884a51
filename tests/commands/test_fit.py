from pathlib import Path

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
