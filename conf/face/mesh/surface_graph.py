"""Distances along the surface of a mesh that may have seams, several components and loose parts."""

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components, dijkstra
from scipy.spatial import KDTree


class SurfaceGraph:
    """The edges of a mesh as a weighted graph, its components joined where their borders touch.

    Files repeat vertices: STL for every triangle, others along texture seams and between materials. Coinciding
    vertices are joined if they lie on open edges of different components. Within one component they stay apart:
    they may be closed lips.
    """

    def __init__(self, vertices: NDArray[np.float64], triangles: NDArray[np.int32], /) -> None:
        """vertices : (V, 3); triangles : (F, 3)."""
        self._vertices = vertices
        edges = _pair_counts(triangle_edges(triangles), len(vertices))
        ends = _entry_indices(edges)
        labels = connected_components(edges, directed=False)[1]
        seams = _seam_pairs(vertices, np.unique(ends[edges.data == 1]), labels)
        if len(seams):
            edges = _pair_counts(np.concatenate([ends, seams]), len(vertices))
            ends = _entry_indices(edges)
            labels = connected_components(edges, directed=False)[1]
        lengths = np.linalg.norm(vertices[ends[:, 0]] - vertices[ends[:, 1]], axis=1)
        # SciPy reads a stored zero as a missing edge.
        min_length = 1e-12 * max(float(lengths.max(initial=0.0)), 1e-290)
        self._graph = csr_array((np.maximum(lengths, min_length), edges.indices, edges.indptr), shape=edges.shape)
        self.components: NDArray[np.int32] = labels  # (V,) label of the component of each vertex

    def nearest_vertices(self, positions: NDArray[np.float64], /, *, tolerance: float) -> NDArray[np.intp]:
        """Return the (n,) vertex nearest to each position (n, 3).

        Lashes or an eyeball may be nearer than the skin: the component nearest to most positions wins if its vertex is
        farther by at most the tolerance.
        """
        distance, nearest = _tree(self._vertices).query(positions)
        main = np.flatnonzero(self.components == np.bincount(self.components[nearest]).argmax())
        main_distance, main_nearest = _tree(self._vertices[main]).query(positions)
        return np.where(main_distance <= distance + tolerance, main[main_nearest], nearest)

    def vertices_within(self, position: NDArray[np.float64], /, *, tolerance: float) -> NDArray[np.intp]:
        """Return the vertices whose distance from the position (3,) exceeds the smallest by at most the tolerance."""
        distance = np.linalg.norm(self._vertices - position, axis=1)
        return np.flatnonzero(distance <= distance.min() + tolerance)

    def distances(self, seeds: NDArray[np.intp], /, *, limit: float) -> NDArray[np.float64]:
        """Return the (V,) distance of each vertex to the nearest seed along the edges, at most the limit."""
        reached = dijkstra(self._graph, directed=False, indices=np.unique(seeds), min_only=True, limit=limit)
        return np.minimum(reached, limit)

    def parent_vertices(self, seeds: NDArray[np.intp], /) -> NDArray[np.intp]:
        """Return for each vertex (V,) the vertex whose region it belongs to.

        That is the vertex itself in a component with a seed. Loose parts, such as lashes or buttons, belong to the
        nearest vertex of such a component.
        """
        parents = np.arange(len(self._vertices))
        loose = np.isin(self.components, self.components[seeds], invert=True)
        if loose.any():
            seeded = np.flatnonzero(~loose)
            parents[loose] = seeded[_tree(self._vertices[seeded]).query(self._vertices[loose])[1]]
        return parents


def triangle_edges(triangles: NDArray[np.int32], /) -> NDArray[np.int32]:
    """Return the (3F, 2) edges of triangles (F, 3)."""
    return triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)


def component_labels(edges: NDArray[np.integer], vertex_count: int, /) -> NDArray[np.int32]:
    """Return the (V,) label of the connected component of each vertex. edges : (E, 2)."""
    return np.asarray(connected_components(_pair_counts(edges, vertex_count), directed=False)[1])


def _tree(positions: NDArray[np.float64]) -> KDTree:
    return KDTree(positions, balanced_tree=False, compact_nodes=False)  # built in a third of the time


def _pair_counts(pairs: NDArray[np.integer], count: int) -> csr_array[np.int32, tuple[int, int]]:
    """Return a matrix with the number of times each pair a < b occurs; pairs of equal indices are left out."""
    pairs = pairs[pairs[:, 0] != pairs[:, 1]]
    ends = (pairs.min(axis=1), pairs.max(axis=1))
    matrix = csr_array((np.ones(len(pairs), dtype=np.int32), ends), shape=(count, count))
    matrix.sum_duplicates()
    return matrix


def _entry_indices(matrix: csr_array[np.int32, tuple[int, int]]) -> NDArray[np.int64]:
    """Return the (E, 2) rows and columns of the entries, in their order."""
    rows = np.repeat(np.arange(matrix.shape[0]), np.diff(matrix.indptr))
    return np.stack([rows, matrix.indices.astype(np.int64)], axis=1)


def _seam_pairs(
    vertices: NDArray[np.float64], candidates: NDArray[np.int64], labels: NDArray[np.int32]
) -> NDArray[np.int64]:
    """Return (J, 2) pairs of candidates that coincide but belong to different components."""
    positions = vertices[candidates].astype(np.float32)
    order = np.lexsort((labels[candidates], *positions.T))
    first, second = order[:-1], order[1:]
    joined = (positions[first] == positions[second]).all(axis=1)
    joined &= labels[candidates[first]] != labels[candidates[second]]
    return np.stack([candidates[first[joined]], candidates[second[joined]]], axis=1)
