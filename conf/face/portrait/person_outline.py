"""The person's outline in a photograph: which triangles show some of him, and how he goes on beyond the border."""

import numpy as np
from numpy.typing import NDArray

BORDER = 0.97  # of the way from the picture's middle to its border: what reaches it is cut off by it
BORDER_EXTENSION = (
    0.25  # picture heights that the person goes on beyond the border: hair cut off there goes on a little
)
OUTLINE_MARGIN_CM = 0.8  # beyond the outline, over which the person's edge fades


def extend_outline(outline: NDArray[np.float64], aspect: float) -> NDArray[np.float64]:
    """Return the outline (K, 2) with what touches the picture's border drawn out beyond it."""
    half = np.array([aspect / 2, 0.5])
    return np.asarray(np.where(np.abs(outline) > BORDER * half, np.sign(outline) * (half + BORDER_EXTENSION), outline))


def triangles_on_person(
    places: NDArray[np.float64], triangles: NDArray[np.int32], outline: NDArray[np.float64], margin: float
) -> NDArray[np.bool_]:
    """Tell the triangles that show some of the person: what is only background need not move, and cannot fold."""
    corners = places[triangles]
    if len(outline) < 3:
        return np.ones(len(triangles), dtype=bool)
    middles = corners.mean(axis=1)
    reach = np.linalg.norm(corners - middles[:, None], axis=2).max(axis=1)
    return np.asarray(_inside(middles, outline) | (_distance(middles, outline) < reach + margin))


def _inside(points: NDArray[np.float64], outline: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Tell the points (k, 2) inside a closed outline: a ray to the right crosses it an odd number of times."""
    a, b = outline, np.roll(outline, -1, axis=0)
    x, y = points[:, :1], points[:, 1:]
    crosses = (a[:, 1] > y) != (b[:, 1] > y)
    rise = np.where(a[:, 1] == b[:, 1], 1.0, b[:, 1] - a[:, 1])
    at = a[:, 0] + (y - a[:, 1]) / rise * (b[:, 0] - a[:, 0])
    return np.asarray(np.count_nonzero(crosses & (x < at), axis=1) % 2 == 1)


def _distance(points: NDArray[np.float64], outline: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return (k,) how far points are from the nearest side of a closed outline."""
    sides = np.roll(outline, -1, axis=0) - outline
    away = points[:, None] - outline
    along = np.sum(away * sides, axis=2) / np.maximum(np.sum(sides * sides, axis=1), 1e-12)
    nearest = np.clip(along, 0, 1)[..., None] * sides
    return np.asarray(np.linalg.norm(away - nearest, axis=2).min(axis=1))
