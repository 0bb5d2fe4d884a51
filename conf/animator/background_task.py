"""Run one task at a time in the background while the window keeps drawing; only the newest waiting task is kept."""

import os
import sys
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Generic, TypeVar

NICENESS = 5  # of nice: about a third of a fully loaded core
Result = TypeVar("Result")


class LatestTaskWorker(Generic[Result]):
    """Runs tasks on one thread. A new task replaces the waiting one; the running one is always finished."""

    def __init__(self) -> None:
        self._pool = ThreadPoolExecutor(1, thread_name_prefix="conf-worker", initializer=_lower_priority)
        self._running: Future[Result] | None = None
        self._waiting: Callable[[], Result] | None = None

    @property
    def busy(self) -> bool:
        """Whether a task is running, or has ended and its result was not polled."""
        return self._running is not None

    def submit(self, task: Callable[[], Result], /) -> None:
        """Run a task as soon as the running one has ended."""
        self._waiting = task
        self._start()

    def poll(self) -> Result | None:
        """Return the result of a task that has ended since the last call, else None. Raises what the task raised."""
        if self._running is None or not self._running.done():
            return None
        ended, self._running = self._running, None
        self._start()
        return ended.result()

    def close(self) -> None:
        """Wait for the running task, drop the waiting one."""
        self._waiting = None
        self._pool.shutdown(wait=True, cancel_futures=True)

    def _start(self) -> None:
        if self._running is None and self._waiting is not None:
            self._running, self._waiting = self._pool.submit(self._waiting), None


def _lower_priority() -> None:
    """Give drawing priority. Only Linux has a niceness for each thread."""
    if sys.platform == "linux":
        os.nice(NICENESS)
