"""Make the winding of neighbouring triangles the same.

Strategy. Across an edge that two triangles share, both have the same winding if they traverse it in opposite
directions. In a graph with two nodes a triangle, as it is and flipped, each shared edge connects the nodes that agree:
every surface with two sides then has two components, and one of them is chosen.
"""

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.csgraph import connected_components

_MIXERS = np.array([0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9], dtype=np.uint64)


def consistent_flips(positions: NDArray[np.float64], triangles: NDArray[np.integer], /) -> NDArray[np.bool_]:
    """Return (F,) which triangles to flip, so that each connected surface has one winding: that of most of its area.

    positions : (V, 3); vertices at the same position count as one
    triangles : (F, 3)
    Surfaces without two sides, and edges of more than two triangles, are left as they are.
    """
    welded = weld_indices(positions)[triangles]
    starts, ends = welded.ravel(), np.roll(welded, -1, axis=1).ravel()
    none = np.zeros(len(triangles), np.bool_)
    directed = np.sort(starts * len(positions) + ends)
    if not (directed[1:] == directed[:-1]).any():  # no edge is traversed twice in one direction
        return none
    first, second, agree = _shared_edges(starts, ends, len(positions))
    if agree.all():
        return none
    count = len(triangles)
    rows = np.concatenate([first, first + count])
    columns = np.concatenate([np.where(agree, second, second + count), np.where(agree, second + count, second)])
    graph = sparse.coo_array((np.ones(len(rows), np.bool_), (rows, columns)), (2 * count, 2 * count))
    labels = connected_components(graph, directed=False)[1]
    same, flipped = labels[:count], labels[count:]
    corners = positions[triangles]
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) + 1e-300
    weight = np.bincount(same, area, 2 * count) - np.bincount(flipped, area, 2 * count)
    # The component that holds more area as it is wins; a component without two sides is its own mirror image.
    return np.asarray((weight[same] < weight[flipped]) | ((weight[same] == weight[flipped]) & (same > flipped)))


def closed_inside_out(positions: NDArray[np.float64], triangles: NDArray[np.integer], /) -> NDArray[np.bool_]:
    """Return (F,) which triangles belong to a closed surface that encloses a negative volume, such as an eyeball.

    positions : (V, 3); triangles : (F, 3), of consistent winding
    """
    welded = weld_indices(positions)[triangles]
    starts, ends = welded.ravel(), np.roll(welded, -1, axis=1).ravel()
    count = len(positions)
    graph = sparse.coo_array((np.ones(len(starts), np.bool_), (starts, ends)), (count, count))
    labels = connected_components(graph, directed=False)[1][welded[:, 0]]
    sums = np.stack([np.bincount(labels, positions[triangles[:, 0], axis], count) for axis in range(3)], axis=1)
    centres = sums / np.maximum(np.bincount(labels, minlength=count), 1)[:, None]
    a, b, c = (positions[triangles[:, corner]] - centres[labels] for corner in range(3))
    negative = (np.bincount(labels, np.einsum("fi,fi->f", a, np.cross(b, c)), count) < 0)[labels]
    if not negative.any():
        return np.asarray(negative)
    edges = np.repeat(negative, 3)
    directed, backward = (p[edges] * count + q[edges] for p, q in ((starts, ends), (ends, starts)))
    is_closed = np.isin(backward, directed).reshape(-1, 3).all(axis=1)
    is_open = np.bincount(labels[negative], ~is_closed, count) > 0
    return np.asarray(negative & ~is_open[labels])


def weld_indices(positions: NDArray[np.float64], /) -> NDArray[np.int64]:
    """Return (V,) the same number for vertices at the same position."""
    bits = (np.ascontiguousarray(positions, np.float64) + 0.0).view(np.uint64)  # + 0.0 makes -0.0 equal 0.0
    mixed = bits * _MIXERS
    mixed ^= mixed >> np.uint64(29)
    keys = (mixed * _MIXERS[::-1]).sum(axis=1, dtype=np.uint64)
    return np.asarray(np.unique(keys, return_inverse=True)[1], dtype=np.int64).ravel()


def _shared_edges(
    starts: NDArray[np.int64], ends: NDArray[np.int64], count: int
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.bool_]]:
    """Return the two triangles of each edge that exactly two share, and whether their winding agrees."""
    keys = np.minimum(starts, ends) * count + np.maximum(starts, ends)
    order = np.argsort(keys, kind="stable")
    edges, first = np.unique(keys[order], return_index=True)
    lengths = np.diff([*first, len(keys)]) if len(edges) else np.empty(0, np.int64)
    at = first[lengths == 2]
    a, b = order[at], order[at + 1]
    proper = (a // 3 != b // 3) & (starts[a] != ends[a])
    a, b = a[proper], b[proper]
    return a // 3, b // 3, starts[a] != starts[b]
