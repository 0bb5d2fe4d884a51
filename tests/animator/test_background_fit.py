import os
import sys
import threading
from collections.abc import Callable
from functools import partial
from pathlib import Path
from threading import Event

import numpy as np
import pytest

from conf.animator.background_fit import NICENESS, Axes, BackgroundFit, FitProgress, FitResult, LatestTaskWorker
from conf.errors import ConfError


def wait_for(fitting: BackgroundFit) -> tuple[Path, FitResult]:
    while (result := fitting.poll()) is None:
        pass
    return result


def test_a_result_is_returned_once_with_its_file() -> None:
    started, finish = Event(), Event()

    def fit(path: Path, axes: Axes, on_progress: Callable[[float, str], None]) -> FitResult:
        on_progress(0.5, f"trying {axes}")
        started.set()
        assert finish.wait(10)
        return FitResult(np.zeros((50, 3)), ("no mouth",))

    fitting = BackgroundFit(fit)
    assert fitting.available and fitting.progress is None and fitting.poll() is None
    fitting.start(Path("a.obj"), ("z", None))
    assert started.wait(10)
    assert fitting.progress == FitProgress(0.5, "trying ('z', None)") and fitting.poll() is None
    finish.set()
    path, result = wait_for(fitting)
    assert path == Path("a.obj") and result.remarks == ("no mouth",)
    assert fitting.progress is None and fitting.poll() is None
    fitting.close()


def test_polling_raises_what_the_fit_raised() -> None:
    def fit(path: Path, axes: Axes, on_progress: Callable[[float, str], None]) -> FitResult:
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


def wait_for_result(worker: LatestTaskWorker[int]) -> int:
    while (result := worker.poll()) is None:
        pass
    return result


def test_only_the_newest_waiting_task_runs() -> None:
    worker: LatestTaskWorker[int] = LatestTaskWorker()
    gate = threading.Event()
    done: list[int] = []

    def note(number: int) -> int:
        done.append(number)
        return number

    def slow() -> int:
        gate.wait(10)
        return note(0)

    worker.submit(slow)
    for i in range(1, 5):
        worker.submit(partial(note, i))
    assert worker.poll() is None and worker.busy
    gate.set()
    assert wait_for_result(worker) == 0
    assert wait_for_result(worker) == 4
    assert done == [0, 4] and not worker.busy
    worker.close()


def test_polling_raises_what_the_task_raised() -> None:
    worker: LatestTaskWorker[int] = LatestTaskWorker()
    worker.submit(lambda: 1 // 0)
    with pytest.raises(ZeroDivisionError):
        wait_for_result(worker)
    worker.close()


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux has a niceness for each thread")
def test_the_thread_has_a_lower_priority() -> None:
    worker: LatestTaskWorker[int] = LatestTaskWorker()
    own = os.getpriority(os.PRIO_PROCESS, 0)
    worker.submit(lambda: os.getpriority(os.PRIO_PROCESS, 0))
    niceness = wait_for_result(worker)
    worker.close()
    assert niceness == min(own + NICENESS, 19) and os.getpriority(os.PRIO_PROCESS, 0) == own
