"""Shut lips and lids have no room for triangles between them: part them a little in the photograph's mesh."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from conf.face.portrait import contours

LEAST_GAP_CM = 0.03
OPENED = 0.2  # of a slit's length: how far up and down what is around it is pressed
OPENINGS = [
    (contours.landmark_rows(upper), contours.landmark_rows(lower))  # each from corner to corner, the corners shared
    for upper, lower in (
        (contours.UPPER_INNER_LIP, contours.LOWER_INNER_LIP),
        (contours.UPPER_LID_R, contours.LOWER_LID_R),
        (contours.UPPER_LID_L, contours.LOWER_LID_L),
    )
]


@dataclass(frozen=True)
class Opening:
    """The line between two lips or lids, seen along it: `along` and `up` are its axes, heights are from its line."""

    origin: NDArray[np.float64]
    along: NDArray[np.float64]
    up: NDArray[np.float64]
    length: float
    upper: NDArray[np.float64]  # (k, 2) places along the slit and heights
    lower: NDArray[np.float64]

    @classmethod
    def between(cls, upper: NDArray[np.float64], lower: NDArray[np.float64]) -> "Opening":
        """See the slit between two lines (k, 2) that share their ends."""
        origin, corner = upper[0], upper[-1]
        length = max(float(np.linalg.norm(corner - origin)), 1e-9)
        along = (corner - origin) / length
        up = np.array([-along[1], along[0]])
        up = up if up[1] >= 0 else -up
        axes = np.stack([along, up], axis=1)
        return cls(origin, along, up, length, (upper - origin) @ axes, (lower - origin) @ axes)

    @property
    def step(self) -> NDArray[np.float64]:
        """Return (2,) as far up as the slit is long."""
        return self.length * self.up

    def contains(self, places: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Tell the places (k, 2) between the two lines."""
        at, height = (places - self.origin) @ self.along, (places - self.origin) @ self.up
        above, below = height > height_of(self.lower, at), height < height_of(self.upper, at)
        return np.asarray((at > 0) & (at < self.length) & above & below)

    def heights(self, places: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return how far places (k, 2) are along the slit, and how high above its middle line."""
        at, height = (places - self.origin) @ self.along, (places - self.origin) @ self.up
        return at, height - (height_of(self.upper, at) + height_of(self.lower, at)) / 2


def enforce_min_gap(places: NDArray[np.float64], centimetre: float, /) -> NDArray[np.float64]:
    """Return the shape's points (D, 2) with lips and lids at least LEAST_GAP_CM apart all along.

    places : (D, 2) picture heights, x right, y up, as contours.ALL
    centimetre : its length in the picture
    """
    parted = places.copy()
    for upper, lower in OPENINGS:
        slit = Opening.between(places[upper], places[lower])
        for side, sense in ((upper[1:-1], 1.0), (lower[1:-1], -1.0)):
            _, height = slit.heights(places[side])
            lack = np.maximum(0.0, LEAST_GAP_CM * centimetre / 2 - sense * height)
            parted[side] += sense * lack[:, None] * slit.up
    return parted


def widen_openings(
    places: NDArray[np.float64], points: NDArray[np.float64], centimetre: float, /
) -> NDArray[np.float64]:
    """Return places (V, 2) with mouth and eyes opened wider, what is around them pressed together, nothing folded.

    points : (D, 2) the shape's points, as contours.ALL; no unit but that of places
    """
    opened = places.copy()
    for upper, lower in OPENINGS:
        slit = Opening.between(points[upper], points[lower])
        at, height = slit.heights(places)
        share = at / slit.length
        bulge = np.sqrt(np.clip(4 * share * (1 - share), 0, 1))
        depth = OPENED * slit.length
        fall = np.maximum(np.exp(-np.abs(height) / depth) - 0.01, 0)
        moved = np.sign(height) * 0.8 * depth * bulge * fall
        opened += moved[:, None] * slit.up
    return opened


def inside_openings(places: NDArray[np.float64], points: NDArray[np.float64], margin: float, /) -> NDArray[np.bool_]:
    """Tell the places (k, 2) between lips or lids, or nearer to them than the margin. points : (D, 2) as ALL."""
    between = np.zeros(len(places), dtype=bool)
    for upper, lower in OPENINGS:
        slit = Opening.between(points[upper], points[lower])
        at, height = slit.heights(places)
        half_gap = (height_of(slit.upper, at) - height_of(slit.lower, at)) / 2
        between |= (at > -margin) & (at < slit.length + margin) & (np.abs(height) < half_gap + margin)
    return between


def height_of(line: NDArray[np.float64], at: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the height of a line (k, 2) at places along it."""
    order = np.argsort(line[:, 0])
    return np.asarray(np.interp(at, line[order, 0], line[order, 1]))
