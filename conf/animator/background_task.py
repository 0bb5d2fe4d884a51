"""One task at a time in the background, the newest wish only: the picture goes on meanwhile."""

import os
import sys
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Generic, TypeVar

NICENESS = 5  # of nice: a third of the processor's time while everybody wants it
Result = TypeVar("Result")


class LatestTaskWorker(Generic[Result]):
    """Runs tasks on one thread. A task that waits is replaced by the next; one that runs is finished and shown."""

    def __init__(self) -> None:
        self._pool = ThreadPoolExecutor(1, thread_name_prefix="conf-worker", initializer=_lower_priority)
        self._running: Future[Result] | None = None
        self._waiting: Callable[[], Result] | None = None

    @property
    def busy(self) -> bool:
        """Whether something is under way."""
        return self._running is not None

    def submit(self, task: Callable[[], Result], /) -> None:
        """Do a task as soon as the one under way is done."""
        self._waiting = task
        self._start()

    def poll(self) -> Result | None:
        """Return what a task has returned since the last call, None if none has ended. Raises what it raised."""
        if self._running is None or not self._running.done():
            return None
        ended, self._running = self._running, None
        self._start()
        return ended.result()

    def close(self) -> None:
        """Wait for what runs, forget what waits."""
        self._waiting = None
        self._pool.shutdown(wait=True, cancel_futures=True)

    def _start(self) -> None:
        if self._running is None and self._waiting is not None:
            self._running, self._waiting = self._pool.submit(self._waiting), None


def _lower_priority() -> None:
    """Let the picture have the processor first, where the system can tell threads apart."""
    if sys.platform == "linux":
        os.nice(NICENESS)
