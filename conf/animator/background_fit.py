"""Find control points in the background. The function that finds them is injected: it needs the face trackers."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from conf.animator.background_task import LatestTaskWorker

Axes = tuple[str | None, str | None]


@dataclass(frozen=True)
class FitResult:
    """Control points that were found.

    points : (n, 3) in the frame and unit of the mesh's file
    remarks : what the user should check
    """

    points: NDArray[np.float64]
    remarks: tuple[str, ...] = ()


class FitFunction(Protocol):
    """Finds the face in a mesh file."""

    def __call__(self, path: Path, axes: Axes, on_progress: Callable[[str], None], /) -> FitResult:
        """Return its control points. axes : the file's up and front axes, None to try all. Raises ConfError."""


class BackgroundFit:
    """Runs one fit at a time. function : None if fitting is not available."""

    def __init__(self, function: FitFunction | None) -> None:
        self._function = function
        self._worker: LatestTaskWorker[tuple[Path, FitResult]] = LatestTaskWorker()
        self._progress = ""

    @property
    def available(self) -> bool:
        """Whether a fit can be started."""
        return self._function is not None

    @property
    def progress(self) -> str | None:
        """Description of the current step, None if no fit is running."""
        return self._progress if self._worker.busy else None

    def start(self, path: Path, axes: Axes) -> None:
        """Start to fit a mesh file. Raises ValueError if fitting is not available."""
        function = self._function
        if function is None:
            raise ValueError("function must be given")
        self._progress = "looking for the face"
        self._worker.submit(lambda: (path, function(path, axes, self._on_progress)))

    def poll(self) -> tuple[Path, FitResult] | None:
        """Return the file and the result of a fit that has ended, once. Raises what the fit raised."""
        return self._worker.poll()

    def close(self) -> None:
        """Wait for the running fit."""
        self._worker.close()

    def _on_progress(self, text: str) -> None:
        self._progress = text
