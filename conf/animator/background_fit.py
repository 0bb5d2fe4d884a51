"""Find the control points in the background. Who does it comes from outside: trackers are no part of this."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from conf.animator.background_task import LatestTaskWorker


@dataclass(frozen=True)
class FitResult:
    """Control points that were found.

    points : (n, 3) in the coordinates of the mesh's file
    remarks : what the user should look at
    """

    points: NDArray[np.float64]
    remarks: tuple[str, ...] = ()


class FitFunction(Protocol):
    """Looks for the face in a mesh file."""

    def __call__(
        self, path: Path, axes: tuple[str | None, str | None], on_progress: Callable[[str], None], /
    ) -> FitResult:
        """Return its control points. axes : towards crown and nose, None to try. Raises ConfError: there is no face."""


class BackgroundFit:
    """One search at a time, while the window goes on."""

    def __init__(self, fit: FitFunction | None) -> None:
        """fit : what searches; None if nothing can"""
        self._fit = fit
        self._worker: LatestTaskWorker[tuple[Path, FitResult]] = LatestTaskWorker()
        self._progress = ""

    @property
    def available(self) -> bool:
        """Whether there is anything that can search."""
        return self._fit is not None

    @property
    def progress(self) -> str | None:
        """How far it is, in words; None when nothing is under way."""
        return self._progress if self._worker.busy else None

    def start(self, path: Path, axes: tuple[str | None, str | None]) -> None:
        """Start to look for the face in a mesh file."""
        fit = self._fit
        if fit is None:
            raise ValueError("fit must be given")
        self._progress = "looking for the face"
        self._worker.submit(lambda: (path, fit(path, axes, self._say)))

    def poll(self) -> tuple[Path, FitResult] | None:
        """Return the file and what was found in it, once. Raises what the search raised."""
        return self._worker.poll()

    def close(self) -> None:
        """Wait for the search that is under way."""
        self._worker.close()

    def _say(self, text: str) -> None:
        self._progress = text
