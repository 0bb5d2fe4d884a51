from collections.abc import Callable
from pathlib import Path
from threading import Event

import numpy as np
import pytest

from conf.animator.background_fit import BackgroundFit, FitResult
from conf.errors import ConfError


def found(fitting: BackgroundFit) -> tuple[Path, FitResult]:
    while (taken := fitting.poll()) is None:
        pass
    return taken


def test_points_come_once_with_the_file_they_belong_to() -> None:
    def fit(path: Path, axes: tuple[str | None, str | None], on_progress: Callable[[str], None]) -> FitResult:
        on_progress(f"trying {axes}")
        told.set()
        assert seen.wait(10)
        return FitResult(np.zeros((50, 3)), ("no mouth",))

    told, seen = Event(), Event()
    fitting = BackgroundFit(fit)
    assert fitting.available and fitting.progress is None and fitting.poll() is None
    fitting.start(Path("a.obj"), ("z", None))
    assert told.wait(10)
    assert fitting.progress == "trying ('z', None)" and fitting.poll() is None
    seen.set()
    path, result = found(fitting)
    assert path == Path("a.obj") and result.remarks == ("no mouth",)
    assert fitting.progress is None and fitting.poll() is None
    fitting.close()


def test_a_mesh_without_a_face_is_said_and_nothing_can_be_asked_of_nobody() -> None:
    def fit(path: Path, axes: tuple[str | None, str | None], on_progress: Callable[[str], None]) -> FitResult:
        raise ConfError("no face is seen")

    fitting = BackgroundFit(fit)
    fitting.start(Path("a.obj"), (None, None))
    with pytest.raises(ConfError, match="no face is seen"):
        found(fitting)
    fitting.close()
    nobody = BackgroundFit(None)
    assert not nobody.available
    with pytest.raises(ValueError, match="fit must be given"):
        nobody.start(Path("a.obj"), (None, None))
