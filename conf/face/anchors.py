"""Anchors: places of a face that stay still whatever the control points do, skull, ears and neck."""

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

_CLEAR = 0.55  # eye distances that an anchor keeps from every control point
_COUNT = 18


def choose_anchors(
    vertices: NDArray[np.float64], points: NDArray[np.float64], /, *, eye_distance: float
) -> NDArray[np.float64]:
    """Pick vertices far from the control points and from each other, farthest first.

    vertices : (V, 3), points : (n, 3), in one length unit
    Returns (k, 3), at most 18; none on a mask that ends where the control points end.
    """
    distance = np.asarray(KDTree(points).query(vertices)[0])
    places = vertices[distance > _CLEAR * eye_distance]
    distance = distance[distance > _CLEAR * eye_distance]
    chosen: list[NDArray[np.float64]] = []
    while len(chosen) < _COUNT and len(places) and distance.max() > _CLEAR * eye_distance:
        chosen.append(places[distance.argmax()])
        distance = np.minimum(distance, np.linalg.norm(places - chosen[-1], axis=1))
    return np.array(chosen).reshape(-1, 3)
