import os
import sys
import threading
from functools import partial

import pytest

from conf.animator.background_task import NICENESS, LatestTaskWorker


def wait_for(worker: LatestTaskWorker[int]) -> int:
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
    assert wait_for(worker) == 0
    assert wait_for(worker) == 4
    assert done == [0, 4] and not worker.busy
    worker.close()


def test_polling_raises_what_the_task_raised() -> None:
    worker: LatestTaskWorker[int] = LatestTaskWorker()
    worker.submit(lambda: 1 // 0)
    with pytest.raises(ZeroDivisionError):
        wait_for(worker)
    worker.close()


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux has a niceness for each thread")
def test_the_thread_has_a_lower_priority() -> None:
    worker: LatestTaskWorker[int] = LatestTaskWorker()
    own = os.getpriority(os.PRIO_PROCESS, 0)
    worker.submit(lambda: os.getpriority(os.PRIO_PROCESS, 0))
    niceness = wait_for(worker)
    worker.close()
    assert niceness == min(own + NICENESS, 19) and os.getpriority(os.PRIO_PROCESS, 0) == own
