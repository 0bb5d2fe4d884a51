from collections.abc import Callable
from pathlib import Path
from threading import Event

import numpy as np
import pytest

from conf.animator.background_fit import Fitted, Fitting
from conf.errors import ConfError


def found(fitting: Fitting) -> tuple[Path, Fitted]:
    while (taken := fitting.take()) is None:
        pass
    return taken


def test_points_come_once_with_the_file_they_belong_to() -> None:
    def fit(path: Path, axes: tuple[str | None, str | None], on_progress: Callable[[str], None]) -> Fitted:
        on_progress(f"trying {axes}")
        told.set()
        assert seen.wait(10)
        return Fitted(np.zeros((50, 3)), ("no mouth",))

    told, seen = Event(), Event()
    fitting = Fitting(fit)
    assert fitting.possible and fitting.progress is None and fitting.take() is None
    fitting.begin(Path("a.obj"), ("z", None))
    assert told.wait(10)
    assert fitting.progress == "trying ('z', None)" and fitting.take() is None
    seen.set()
    path, result = found(fitting)
    assert path == Path("a.obj") and result.remarks == ("no mouth",)
    assert fitting.progress is None and fitting.take() is None
    fitting.close()


def test_a_mesh_without_a_face_is_said_and_nothing_can_be_asked_of_nobody() -> None:
    def fit(path: Path, axes: tuple[str | None, str | None], on_progress: Callable[[str], None]) -> Fitted:
        raise ConfError("no face is seen")

    fitting = Fitting(fit)
    fitting.begin(Path("a.obj"), (None, None))
    with pytest.raises(ConfError, match="no face is seen"):
        found(fitting)
    fitting.close()
    nobody = Fitting(None)
    assert not nobody.possible
    with pytest.raises(ValueError, match="fit must be given"):
        nobody.begin(Path("a.obj"), (None, None))
