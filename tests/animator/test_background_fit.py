from collections.abc import Callable
from pathlib import Path
from threading import Event

import numpy as np
import pytest

from conf.animator.background_fit import Axes, BackgroundFit, FitResult
from conf.errors import ConfError


def wait_for(fitting: BackgroundFit) -> tuple[Path, FitResult]:
    while (result := fitting.poll()) is None:
        pass
    return result


def test_a_result_is_returned_once_with_its_file() -> None:
    started, finish = Event(), Event()

    def fit(path: Path, axes: Axes, on_progress: Callable[[str], None]) -> FitResult:
        on_progress(f"trying {axes}")
        started.set()
        assert finish.wait(10)
        return FitResult(np.zeros((50, 3)), ("no mouth",))

    fitting = BackgroundFit(fit)
    assert fitting.available and fitting.progress is None and fitting.poll() is None
    fitting.start(Path("a.obj"), ("z", None))
    assert started.wait(10)
    assert fitting.progress == "trying ('z', None)" and fitting.poll() is None
    finish.set()
    path, result = wait_for(fitting)
    assert path == Path("a.obj") and result.remarks == ("no mouth",)
    assert fitting.progress is None and fitting.poll() is None
    fitting.close()


def test_polling_raises_what_the_fit_raised() -> None:
    def fit(path: Path, axes: Axes, on_progress: Callable[[str], None]) -> FitResult:
        raise ConfError("no face found")

    fitting = BackgroundFit(fit)
    fitting.start(Path("a.obj"), (None, None))
    with pytest.raises(ConfError, match="no face found"):
        wait_for(fitting)
    fitting.close()


def test_without_a_function_no_fit_can_start() -> None:
    fitting = BackgroundFit(None)
    assert not fitting.available
    with pytest.raises(ValueError, match="function must be given"):
        fitting.start(Path("a.obj"), (None, None))
