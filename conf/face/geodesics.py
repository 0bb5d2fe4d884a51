"""Distances along the surface of a mesh, whatever its state: seams, several shells, loose parts."""

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components, dijkstra
from scipy.spatial import KDTree


class Surface:
    """The edges of a mesh as a graph, its seams closed.

    Files repeat vertices along texture seams, STL for every triangle. Vertices at one place are taken as one, but only
    where the mesh has an open edge: closed lips may touch in one place and must stay apart.
    """

    def __init__(self, vertices: NDArray[np.float64], triangles: NDArray[np.int32], /) -> None:
        """Take (V, 3) positions and (F, 3) indices into them."""
        self._vertices = vertices
        edges, open_edge = _edges(triangles.astype(np.int64), len(vertices))
        self._node = _weld(vertices, np.unique(edges[open_edge]))
        ends = self._node[edges]
        ends = _unique_pairs(ends[ends[:, 0] != ends[:, 1]], len(vertices))
        lengths = np.linalg.norm(vertices[ends[:, 0]] - vertices[ends[:, 1]], axis=1)
        # scipy takes a stored zero for no edge at all
        lengths = np.maximum(lengths, 1e-12 * max(float(lengths.max(initial=0.0)), 1e-290))
        self._graph = csr_array((lengths, (ends[:, 0], ends[:, 1])), shape=(len(vertices), len(vertices)))
        self._shell: NDArray[np.int32] = connected_components(self._graph, directed=False)[1][self._node]

    def snap(self, places: NDArray[np.float64], /, *, tolerance: float) -> NDArray[np.intp]:
        """Return the nearest vertex of each place, (n,).

        Lashes or an eyeball may be nearer than the skin: the shell that most places are on wins within the tolerance.
        """
        distance, nearest = KDTree(self._vertices).query(places)
        main = np.flatnonzero(self._shell == np.bincount(self._shell[nearest]).argmax())
        main_distance, main_nearest = KDTree(self._vertices[main]).query(places)
        return np.where(main_distance <= distance + tolerance, main[main_nearest], nearest)

    def distances(self, seeds: NDArray[np.intp], /, *, limit: float) -> NDArray[np.float64]:
        """Return the (V,) distance of each vertex to the nearest seed along the edges, at most the limit."""
        nodes = np.unique(self._node[seeds])
        reached = dijkstra(self._graph, directed=False, indices=nodes, min_only=True, limit=limit)
        return np.minimum(reached, limit)[self._node]

    def spread(self, values: NDArray[np.float64], seeds: NDArray[np.intp], /) -> NDArray[np.float64]:
        """Return the (V,) values, those of shells without a seed taken from the nearest vertex of a shell with one."""
        seeded = np.isin(self._shell, self._shell[seeds])
        if seeded.all():
            return values
        carrier = np.flatnonzero(seeded)
        _, nearest = KDTree(self._vertices[carrier]).query(self._vertices[~seeded])
        spread = values.copy()
        spread[~seeded] = values[carrier[nearest]]
        return spread


def _edges(triangles: NDArray[np.int64], count: int) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
    """Return the (E, 2) edges, each once, and whether only one triangle has it."""
    pairs = triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    keys, uses = np.unique(pairs.min(axis=1) * count + pairs.max(axis=1), return_counts=True)
    return np.stack(np.divmod(keys, count), axis=1), uses == 1


def _unique_pairs(ends: NDArray[np.int64], count: int) -> NDArray[np.int64]:
    """Return each pair once: scipy would add up the lengths of edges that welding made equal."""
    keys = np.unique(ends.min(axis=1) * count + ends.max(axis=1))
    return np.stack(np.divmod(keys, count), axis=1)


def _weld(vertices: NDArray[np.float64], candidates: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the (V,) node of each vertex: candidates at one place share the first of them."""
    node = np.arange(len(vertices))
    if len(candidates):
        places = np.ascontiguousarray(vertices[candidates].astype(np.float32)) + np.float32(0)  # no negative zero
        keys = places.view(np.dtype((np.void, 12))).ravel()
        _, first, inverse = np.unique(keys, return_index=True, return_inverse=True)
        node[candidates] = candidates[first[inverse]]
    return node
