"""The scalp as a height field in polar coordinates around the middle of the head, and the hairline."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator
from scipy.ndimage import gaussian_filter, map_coordinates, median_filter

from tools.assets.head.raycast import distances_along

CENTRE = np.array([0.0, 4.0, -6.0])  # cm, middle of the skull
_AROUND, _DOWN = 96, 56  # cells of the height field
_DEEPEST = np.radians(165.0)

# The hairline of the left side, cm: forehead, temple, sideburn, over the ear, behind it, nape.
_HAIRLINE = np.array(
    [
        (0.0, 9.3, 3.6),
        (2.4, 9.5, 2.9),
        (4.4, 9.3, 1.6),
        (5.6, 8.3, 0.6),
        (6.2, 7.0, 0.0),
        (6.6, 5.4, -0.6),
        (7.0, 3.6, -1.9),
        (7.3, 1.4, -2.9),
        (7.4, -0.2, -3.3),
        (7.5, -0.2, -3.9),
        (7.7, 1.6, -4.5),
        (7.9, 3.1, -5.4),
        (7.9, 3.6, -6.6),
        (7.8, 2.9, -8.3),
        (7.5, 0.9, -9.5),
        (7.0, -1.6, -10.0),
        (5.9, -4.0, -10.8),
        (3.6, -5.3, -12.2),
        (0.0, -5.7, -12.8),
    ]
)


@dataclass(frozen=True)
class Scalp:
    """Distances of the skin from CENTRE.

    radius : (down, around) cm; around runs from the front over the left side, down runs from the crown
    hairline : of this head
    """

    radius: NDArray[np.float64]
    hairline: "Hairline"

    def radius_at(self, around: NDArray[np.float64], down: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the distance of the skin from the centre, cm, in directions given in radians."""
        column = np.mod(around / (2 * np.pi), 1.0) * _AROUND
        row = np.clip(down / _DEEPEST, 0, 1) * (_DOWN - 1)
        padded = np.concatenate([self.radius, self.radius[:, :1]], axis=1)
        return map_coordinates(padded, [row, column], order=1)

    def points(
        self, around: NDArray[np.float64], down: NDArray[np.float64], height: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Return the points at a height above the skin, cm, in directions given in radians."""
        return CENTRE + _directions(around, down) * (self.radius_at(around, down) + height)[..., None]


class Hairline:
    """The outline of the hair."""

    def __init__(self, points: NDArray[np.float64], offsets: NDArray[np.float64] | None = None) -> None:
        """Interpolate the outline.

        points : (N, 3) of the left side on the default head, from the forehead to the nape, cm
        offsets : (N, 3) of another head's skin there, cm; they move the outline up and down only
        """
        self.points = points
        around, down, _ = polar(points)
        self._curve = PchipInterpolator(around, down if offsets is None else polar(points + offsets)[1])

    def __call__(self, around: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the angle of the hairline from the crown, radians."""
        return np.asarray(self._curve(np.abs(np.mod(np.asarray(around) + np.pi, 2 * np.pi) - np.pi)))


def find_hairline(rise: float = 0.0, receding: float = 0.0) -> Hairline:
    """Return the hairline on the default head, higher at the forehead and farther back at the temples, cm."""
    points = _HAIRLINE.copy()
    forehead = np.array([1.0, 1.0, 0.8, 0.3])[:, None] * [0.0, 0.75, -0.65]
    temples = np.array([0.0, 0.75, 1.0, 0.6])[:, None] * [0.0, 0.6, -0.8]
    points[:4] += rise * forehead + receding * temples
    return Hairline(points)


def build_scalp(vertices: NDArray[np.float64], triangles: NDArray[np.int64], hairline: Hairline) -> Scalp:
    """Measure the skull; the ears are removed by a median filter."""
    around = np.arange(_AROUND) * 2 * np.pi / _AROUND
    down = np.linspace(0, _DEEPEST, _DOWN)
    directions = _directions(*np.meshgrid(around, down)).reshape(-1, 3)
    radius = distances_along(CENTRE, directions, vertices, triangles).reshape(_DOWN, _AROUND)
    radius[np.isnan(radius)] = np.nanmedian(radius)
    wrapped = np.pad(np.pad(radius, ((0, 0), (8, 8)), mode="wrap"), ((8, 8), (0, 0)), mode="edge")
    return Scalp(gaussian_filter(median_filter(wrapped, (3, 5)), 0.7)[8:-8, 8:-8], hairline)


def polar(points: NDArray[np.floating]) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Return radians around (0 in front, positive to the left), radians from the crown, cm from the centre."""
    x, y, z = (np.asarray(points, dtype=float) - CENTRE).T
    return np.arctan2(x, z), np.arctan2(np.hypot(x, z), y), np.sqrt(x * x + y * y + z * z)


def _directions(around: NDArray[np.float64], down: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.stack([np.sin(down) * np.sin(around), np.cos(down), np.sin(down) * np.cos(around)], axis=-1)
