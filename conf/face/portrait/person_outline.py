"""The person's outline in a photo: which triangles show the person, and the outline's extension beyond the border."""

import numpy as np
from numpy.typing import NDArray

BORDER = 0.97  # of the distance from centre to border: outline points beyond it are cut off by the border
BORDER_EXTENSION = 0.25  # image heights that the person is extended beyond the border
OUTLINE_MARGIN_CM = 0.8  # beyond the outline, over which the person's edge fades


def extend_outline(outline: NDArray[np.float64], aspect: float) -> NDArray[np.float64]:
    """Return the outline (K, 2) with the parts that touch the border moved beyond it."""
    half = np.array([aspect / 2, 0.5])
    return np.asarray(np.where(np.abs(outline) > BORDER * half, np.sign(outline) * (half + BORDER_EXTENSION), outline))


def triangles_on_person(
    positions: NDArray[np.float64], triangles: NDArray[np.int32], outline: NDArray[np.float64], margin: float
) -> NDArray[np.bool_]:
    """Return (F,) whether triangles show some of the person; those of the background need not move."""
    if len(outline) < 3:
        return np.ones(len(triangles), dtype=bool)
    corners = positions[triangles]
    centres = corners.mean(axis=1)
    radius = np.linalg.norm(corners - centres[:, None], axis=2).max(axis=1)
    return np.asarray(_inside(centres, outline) | (_distance(centres, outline) < radius + margin))


def _inside(points: NDArray[np.float64], outline: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return (k,) whether points are in a closed outline: a ray to the right crosses it an odd number of times."""
    a, b = outline, np.roll(outline, -1, axis=0)
    x, y = points[:, :1], points[:, 1:]
    crosses = (a[:, 1] > y) != (b[:, 1] > y)
    rise = np.where(a[:, 1] == b[:, 1], 1.0, b[:, 1] - a[:, 1])
    crossing_x = a[:, 0] + (y - a[:, 1]) / rise * (b[:, 0] - a[:, 0])
    return np.asarray(np.count_nonzero(crosses & (x < crossing_x), axis=1) % 2 == 1)


def _distance(points: NDArray[np.float64], outline: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return (k,) the distance of points to the nearest side of a closed outline."""
    sides = np.roll(outline, -1, axis=0) - outline
    offsets = points[:, None] - outline
    along = np.sum(offsets * sides, axis=2) / np.maximum(np.sum(sides * sides, axis=1), 1e-12)
    nearest = np.clip(along, 0, 1)[..., None] * sides
    return np.asarray(np.linalg.norm(offsets - nearest, axis=2).min(axis=1))
