"""Cast rays from a point inside the body to its surface."""

import numpy as np
from numpy.typing import NDArray


def distances_along(
    origin: NDArray[np.float64],
    directions: NDArray[np.float64],
    vertices: NDArray[np.float64],
    triangles: NDArray[np.int64],
    *,
    farthest: bool = False,
) -> NDArray[np.float64]:
    """Return (N,) distances from the origin to the nearest or farthest hit along (N, 3) directions, NaN without a hit.

    Source: Möller, Trumbore 1997, vectorised over the triangles.
    """
    a = vertices[triangles[:, 0]]
    first, second = vertices[triangles[:, 1]] - a, vertices[triangles[:, 2]] - a
    to_origin = origin - a
    q = np.cross(to_origin, first)
    reach = np.einsum("ij,ij->i", second, q)
    distances = np.full(len(directions), np.nan)
    for i, direction in enumerate(directions):
        p = np.cross(direction, second)
        area = np.einsum("ij,ij->i", first, p)
        with np.errstate(divide="ignore", invalid="ignore"):
            u = np.einsum("ij,ij->i", to_origin, p) / area
            v = q @ direction / area
            hits = (reach / area)[(u >= -1e-9) & (v >= -1e-9) & (u + v <= 1 + 1e-9)]
        hits = hits[hits > 0]
        if len(hits):
            distances[i] = hits.max() if farthest else hits.min()
    return distances
