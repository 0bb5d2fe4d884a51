"""Keep a gap between closed lips and lids, so that there is room for the mesh's triangles between them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from conf.face.portrait import contours

MIN_GAP_CM = 0.03
WIDENING_DEPTH = 0.2  # of an opening's length: decay length of the widening above and below
OPENINGS = [
    (contours.landmark_rows(upper), contours.landmark_rows(lower))  # each from corner to corner, corners in common
    for upper, lower in (
        (contours.UPPER_INNER_LIP, contours.LOWER_INNER_LIP),
        (contours.UPPER_LID_R, contours.LOWER_LID_R),
        (contours.UPPER_LID_L, contours.LOWER_LID_L),
    )
]


@dataclass(frozen=True)
class Opening:
    """The opening between two lips or lids, with a coordinate system of its own.

    origin : (2,) one corner; along : (2,) unit vector to the other one; up : (2,) unit vector upwards
    upper, lower : (k, 2) the edges, along and up
    """

    origin: NDArray[np.float64]
    along: NDArray[np.float64]
    up: NDArray[np.float64]
    length: float
    upper: NDArray[np.float64]
    lower: NDArray[np.float64]

    @classmethod
    def between(cls, upper: NDArray[np.float64], lower: NDArray[np.float64]) -> "Opening":
        """Return the opening between two edges (k, 2) with common ends."""
        origin, corner = upper[0], upper[-1]
        length = max(float(np.linalg.norm(corner - origin)), 1e-9)
        along = (corner - origin) / length
        up = np.array([-along[1], along[0]])
        up = up if up[1] >= 0 else -up
        axes = np.stack([along, up], axis=1)
        return cls(origin, along, up, length, (upper - origin) @ axes, (lower - origin) @ axes)

    def coordinates(self, positions: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return (k,) along the opening and (k,) up."""
        return (positions - self.origin) @ self.along, (positions - self.origin) @ self.up

    def contains(self, positions: NDArray[np.float64], margin: float = 0.0) -> NDArray[np.bool_]:
        """Return (k,) whether positions are between the edges or nearer to them than the margin."""
        x, height = self.heights(positions)
        half_gap = (height_at(self.upper, x) - height_at(self.lower, x)) / 2
        return np.asarray((x > -margin) & (x < self.length + margin) & (np.abs(height) < half_gap + margin))

    def heights(self, positions: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return (k,) along the opening and (k,) above its centre line."""
        x, height = self.coordinates(positions)
        return x, height - (height_at(self.upper, x) + height_at(self.lower, x)) / 2


def enforce_min_gap(positions: NDArray[np.float64], centimetre: float, /) -> NDArray[np.float64]:
    """Return positions (D, 2) with lips and lids at least MIN_GAP_CM apart. centimetre : in the positions' unit"""
    separated = positions.copy()
    for upper, lower in OPENINGS:
        opening = Opening.between(positions[upper], positions[lower])
        for edge, sign in ((upper[1:-1], 1.0), (lower[1:-1], -1.0)):
            _, height = opening.heights(positions[edge])
            missing = np.maximum(0.0, MIN_GAP_CM * centimetre / 2 - sign * height)
            separated[edge] += sign * missing[:, None] * opening.up
    return separated


def widen_openings(positions: NDArray[np.float64], points: NDArray[np.float64], /) -> NDArray[np.float64]:
    """Return positions (V, 2) with mouth and eyes opened wider and the surroundings compressed, without folds.

    points : (D, 2) landmarks, in the positions' unit
    """
    widened = positions.copy()
    for upper, lower in OPENINGS:
        opening = Opening.between(points[upper], points[lower])
        x, height = opening.heights(positions)
        t = x / opening.length
        bulge = np.sqrt(np.clip(4 * t * (1 - t), 0, 1))
        depth = WIDENING_DEPTH * opening.length
        decay = np.maximum(np.exp(-np.abs(height) / depth) - 0.01, 0)
        widened += (np.sign(height) * 0.8 * depth * bulge * decay)[:, None] * opening.up
    return widened


def inside_openings(positions: NDArray[np.float64], points: NDArray[np.float64], margin: float, /) -> NDArray[np.bool_]:
    """Return (k,) whether positions are between lips or lids, or nearer to them than the margin. points : (D, 2)"""
    openings = (Opening.between(points[upper], points[lower]) for upper, lower in OPENINGS)
    return np.asarray(np.any([opening.contains(positions, margin) for opening in openings], axis=0))


def height_at(edge: NDArray[np.float64], x: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the height of an edge (k, 2) at positions x along the opening."""
    order = np.argsort(edge[:, 0])
    return np.asarray(np.interp(x, edge[order, 0], edge[order, 1]))
