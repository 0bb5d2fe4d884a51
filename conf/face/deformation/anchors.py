"""Anchors: positions on skull, ears and neck that stay still whatever the control points do."""

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

_MIN_DISTANCE = 0.55  # of a chosen anchor from every control point and anchor, in eye distances
_COUNT = 32


def choose_anchors(
    vertices: NDArray[np.float64],
    points: NDArray[np.float64],
    /,
    *,
    eye_distance: float,
    initial: NDArray[np.float64] | None = None,
) -> NDArray[np.float64]:
    """Pick vertices far from the control points and from each other, farthest first.

    vertices : (V, 3), points : (n, 3), initial : (k, 3) given anchors, all in one length unit
    Returns at most 32 anchors, the initial ones first; none on a mask that ends where the control points end.
    """
    chosen = [] if initial is None else list(initial)
    distance = np.asarray(KDTree(points).query(vertices)[0])
    outside = distance > _MIN_DISTANCE * eye_distance
    candidates, distance = vertices[outside], distance[outside]
    for anchor in chosen:
        distance = np.minimum(distance, np.linalg.norm(candidates - anchor, axis=1))
    while len(chosen) < _COUNT and len(candidates) and distance.max() > _MIN_DISTANCE * eye_distance:
        chosen.append(candidates[distance.argmax()])
        distance = np.minimum(distance, np.linalg.norm(candidates - chosen[-1], axis=1))
    return np.array(chosen).reshape(-1, 3)
