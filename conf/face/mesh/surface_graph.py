"""Distances along the surface of a mesh, whatever its state: seams, several shells, loose parts."""

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components, dijkstra
from scipy.spatial import KDTree


class SurfaceGraph:
    """The edges of a mesh as a graph, its shells joined where they touch.

    Files repeat vertices: STL for every triangle, others along texture seams and between materials. Vertices at one
    place are joined if they lie on open edges of different shells. Within one shell they stay apart: they may be
    closed lips.
    """

    def __init__(self, vertices: NDArray[np.float64], triangles: NDArray[np.int32], /) -> None:
        """Take (V, 3) positions and (F, 3) indices into them."""
        self._vertices = vertices
        edges = _count_pairs(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), len(vertices))
        ends = _ends(edges)
        joints = _joints(vertices, np.unique(ends[edges.data == 1]), _shells(edges))
        if len(joints):
            edges = _count_pairs(np.concatenate([ends, joints]), len(vertices))
            ends = _ends(edges)
        lengths = np.linalg.norm(vertices[ends[:, 0]] - vertices[ends[:, 1]], axis=1)
        # scipy takes a stored zero for no edge at all
        shortest = 1e-12 * max(float(lengths.max(initial=0.0)), 1e-290)
        self._graph = csr_array((np.maximum(lengths, shortest), edges.indices, edges.indptr), shape=edges.shape)
        self._shell = _shells(edges)

    @property
    def components(self) -> NDArray[np.int32]:
        """The (V,) number of the shell each vertex is in."""
        return self._shell

    def nearest_vertices(self, places: NDArray[np.float64], /, *, tolerance: float) -> NDArray[np.intp]:
        """Return the nearest vertex of each place, (n,).

        Lashes or an eyeball may be nearer than the skin: the shell that most places are on wins within the tolerance.
        """
        distance, nearest = _tree(self._vertices).query(places)
        main = np.flatnonzero(self._shell == np.bincount(self._shell[nearest]).argmax())
        main_distance, main_nearest = _tree(self._vertices[main]).query(places)
        return np.where(main_distance <= distance + tolerance, main[main_nearest], nearest)

    def vertices_within(self, place: NDArray[np.float64], /, *, tolerance: float) -> NDArray[np.intp]:
        """Return the vertices that are nearest to the place (3,), or farther than the nearest by the tolerance."""
        distance = np.linalg.norm(self._vertices - place, axis=1)
        return np.flatnonzero(distance <= distance.min() + tolerance)

    def distances(self, seeds: NDArray[np.intp], /, *, limit: float) -> NDArray[np.float64]:
        """Return the (V,) distance of each vertex to the nearest seed along the edges, at most the limit."""
        reached = dijkstra(self._graph, directed=False, indices=np.unique(seeds), min_only=True, limit=limit)
        return np.minimum(reached, limit)

    def parent_vertices(self, seeds: NDArray[np.intp], /) -> NDArray[np.intp]:
        """Return the (V,) vertex whose region each vertex shares.

        That is the vertex itself on a shell with a seed; loose parts, such as lashes or buttons, go with the nearest
        vertex of such a shell.
        """
        carriers = np.arange(len(self._vertices))
        loose = np.isin(self._shell, self._shell[seeds], invert=True)
        if loose.any():
            seeded = np.flatnonzero(~loose)
            carriers[loose] = seeded[_tree(self._vertices[seeded]).query(self._vertices[loose])[1]]
        return carriers


def _tree(places: NDArray[np.float64]) -> KDTree:
    return KDTree(places, balanced_tree=False, compact_nodes=False)  # built in a third of the time


def _count_pairs(pairs: NDArray[np.integer], count: int) -> csr_array[np.int32, tuple[int, int]]:
    """Return a matrix that says for each pair a < b how often it occurs; a pair of the same does not count."""
    pairs = pairs[pairs[:, 0] != pairs[:, 1]]
    ends = (pairs.min(axis=1), pairs.max(axis=1))
    matrix = csr_array((np.ones(len(pairs), dtype=np.int32), ends), shape=(count, count))
    matrix.sum_duplicates()
    return matrix


def _ends(matrix: csr_array[np.int32, tuple[int, int]]) -> NDArray[np.int64]:
    """Return the (E, 2) rows and columns of the entries, in their order."""
    rows = np.repeat(np.arange(matrix.shape[0]), np.diff(matrix.indptr))
    return np.stack([rows, matrix.indices.astype(np.int64)], axis=1)


def _shells(edges: csr_array[np.int32, tuple[int, int]]) -> NDArray[np.int32]:
    """Return the (V,) number of the connected part each vertex is in."""
    return np.asarray(connected_components(edges, directed=False)[1])


def _joints(
    vertices: NDArray[np.float64], candidates: NDArray[np.int64], components: NDArray[np.int32]
) -> NDArray[np.int64]:
    """Return (J, 2) pairs of candidates that lie in one place but in different shells."""
    places = vertices[candidates].astype(np.float32)
    order = np.lexsort((components[candidates], *places.T))
    first, second = order[:-1], order[1:]
    joined = (places[first] == places[second]).all(axis=1) & (
        components[candidates[first]] != components[candidates[second]]
    )
    return np.stack([candidates[first[joined]], candidates[second[joined]]], axis=1)
