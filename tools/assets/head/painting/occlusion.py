"""Ambient occlusion by marching rays through a grid of filled cells.

Exact ray casting would need a library with an acceleration structure. Cells of 1.2 mm are small enough for soft shadows
under the chin, in the eye sockets, in the nostrils and behind the ears.
"""

import numpy as np
from numpy.typing import NDArray

_CELL = 0.12  # cm
_REACH = 6.0  # maximum distance of an occluder, cm
_RAYS = 96


def ambient_occlusion(
    points: NDArray[np.float64],
    normals: NDArray[np.float64],
    vertices: NDArray[np.float64],
    triangles: NDArray[np.int64],
    /,
) -> NDArray[np.float64]:
    """Return the (N,) unoccluded fraction of the hemisphere above each point, 0 to 1, cosine-weighted.

    points, normals : (N, 3); vertices (V, 3), triangles (F, 3) : the occluders; cm
    """
    filled, corner = _fill_cells(vertices, triangles)
    steps = _CELL * 1.6 * 1.13 ** np.arange(26)
    distances = np.cumsum(steps)
    distances = distances[distances < _REACH]
    visible, total = np.zeros(len(points)), np.zeros(len(points))
    for direction in _directions():
        weight = np.clip(normals @ direction, 0, None)
        clear = np.ones(len(points))
        for distance in distances:
            sample = points + normals * (1.2 * _CELL) + direction * distance
            cell = ((sample - corner) / _CELL).astype(np.int32)
            np.clip(cell, 0, np.array(filled.shape) - 1, out=cell)
            hit = filled[cell[:, 0], cell[:, 1], cell[:, 2]]
            clear = np.where(hit, np.minimum(clear, (distance / _REACH) ** 0.6), clear)
        visible += weight * clear
        total += weight
    return visible / np.maximum(total, 1e-9)


def _directions() -> NDArray[np.float64]:
    """Return (_RAYS, 3) evenly distributed directions, a Fibonacci sphere."""
    index = np.arange(_RAYS) + 0.5
    height, around = 1 - 2 * index / _RAYS, np.pi * (1 + 5**0.5) * index
    radius = np.sqrt(1 - height**2)
    return np.stack([radius * np.cos(around), height, radius * np.sin(around)], axis=1)


def _fill_cells(
    vertices: NDArray[np.float64], triangles: NDArray[np.int64]
) -> tuple[NDArray[np.bool_], NDArray[np.float64]]:
    """Return the grid of cells that contain surface, with an empty border, and its lowest corner."""
    corner = vertices.min(axis=0) - 2 * _CELL
    size = np.ceil((vertices.max(axis=0) - corner) / _CELL).astype(int) + 3
    filled = np.zeros(size, dtype=bool)
    a, b, c = (vertices[triangles[:, i]] for i in range(3))
    longest = np.max(
        [np.linalg.norm(b - a, axis=1), np.linalg.norm(c - a, axis=1), np.linalg.norm(c - b, axis=1)], axis=0
    )
    splits = np.ceil(longest / (0.7 * _CELL)).astype(int)
    for count in np.unique(splits):
        selected = splits == count
        i, j = (x.ravel() for x in np.meshgrid(np.arange(count + 1), np.arange(count + 1), indexing="ij"))
        i, j = i[i + j <= count] / count, j[i + j <= count] / count
        points = (
            a[selected, None] * (1 - i - j)[:, None] + b[selected, None] * i[:, None] + c[selected, None] * j[:, None]
        ).reshape(-1, 3)
        cell = ((points - corner) / _CELL).astype(int)
        filled[cell[:, 0], cell[:, 1], cell[:, 2]] = True
    return filled, corner
