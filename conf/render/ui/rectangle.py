"""Rectangles of a window."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from conf.render.camera import project


@dataclass(frozen=True)
class Rect:
    """A rectangle of the window: pixels from the upper left corner, y down."""

    x: float
    y: float
    width: float
    height: float

    def contains(self, x: float, y: float) -> bool:
        """Tell whether a pixel lies inside."""
        return self.x <= x < self.x + self.width and self.y <= y < self.y + self.height

    def to_ndc(self, x: float, y: float) -> NDArray[np.float64]:
        """Return (2,) normalised device coordinates of a pixel: -1 to 1 over the rectangle, y up."""
        return np.array([2 * (x - self.x) / self.width - 1, 1 - 2 * (y - self.y) / self.height])

    def to_pixels(self, positions: NDArray[np.floating], clip: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return (n, 2) window pixels of (n, 3) positions in face axes under a (4, 4) clip matrix."""
        pixels: NDArray[np.float64] = project(positions, clip, (self.width, self.height)) + np.array([self.x, self.y])
        return pixels
