"""Background tasks, and finding control points in one: the injected function needs the face trackers."""

import os
import sys
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

Axes = tuple[str | None, str | None]


@dataclass(frozen=True)
class FitResult:
    """Control points that were found.

    points : (n, 3) in the frame and unit of the mesh's file
    remarks : what the user should check
    """

    points: NDArray[np.float64]
    remarks: tuple[str, ...] = ()


@dataclass(frozen=True)
class FitProgress:
    """How far a fit is: the fraction that is done, 0 to 1, and what is done now."""

    fraction: float
    text: str


# Returns the control points of a mesh file. It gets the file, its up and front axes, None to try all, and a function
# that shows the fraction that is done and the current step; it raises ConfError.
FitFunction = Callable[[Path, Axes, Callable[[float, str], None]], FitResult]
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


class BackgroundFit(LatestTaskWorker[tuple[Path, FitResult]]):
    """Fits one mesh file at a time; `poll` returns the file and its result."""

    def __init__(self, function: FitFunction | None) -> None:
        """function : None if fitting is not available"""
        super().__init__()
        self._function = function
        self._progress = FitProgress(0.0, "")

    @property
    def available(self) -> bool:
        """Whether a fit can be started."""
        return self._function is not None

    @property
    def progress(self) -> FitProgress | None:
        """How far the running fit is, None if there is none."""
        return self._progress if self.busy else None

    def start(self, path: Path, axes: Axes) -> None:
        """Start to fit a mesh file. Raises ValueError if fitting is not available."""
        function = self._function
        if function is None:
            raise ValueError("function must be given")
        self._progress = FitProgress(0.0, "reading the mesh")
        self.submit(lambda: (path, function(path, axes, self._on_progress)))

    def _on_progress(self, fraction: float, text: str) -> None:
        self._progress = FitProgress(fraction, text)
