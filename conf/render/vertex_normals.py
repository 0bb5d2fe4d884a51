"""Vertex normals of a deformed mesh, interleaved with the positions as the vertex buffer holds them.

The normal of a vertex is the sum of the cross products of the triangles around it in the welded mesh, so weighted by
area, and no seam of the texture shows. The vertices are sorted by how many triangles they have, most first, because
the topology stays the same while the mesh moves: step n adds the n-th triangle of all vertices that have so many.
"""

import numpy as np
from numpy.typing import NDArray


class VertexNormals:
    """Compute the normals of one mesh; all work arrays are allocated once."""

    def __init__(self, triangles: NDArray[np.integer], render_vertices: NDArray[np.integer], /) -> None:
        """triangles : (F, 3) indices into the vertices; render_vertices : (R,) the vertex of each render vertex."""
        faces = len(triangles)
        self._count = max(int(triangles.max(initial=-1)), int(render_vertices.max())) + 1
        self._corners = np.ascontiguousarray(triangles.T, dtype=np.intp)  # (3, F)
        self._render_vertices = np.ascontiguousarray(render_vertices, dtype=np.intp)
        self._steps, self._rank = _summation_steps(np.asarray(triangles), self._count)
        self._positions = np.empty((3, 3, faces), np.float32)  # axis, corner, face
        self._cross = np.empty((3, faces), np.float32)
        self._edges = np.empty((2, 3, faces), np.float32)
        self._product = np.empty(faces, np.float32)
        self._addends = np.zeros(
            (faces, 4), np.float32
        )  # the cross products: four numbers are copied faster than three
        self._sums = np.empty((self._count, 4), np.float32)
        self._welded = np.empty((self._count, 6), np.float32)
        self._interleaved = np.empty((len(render_vertices), 6), np.float32)

    def normals(self, vertices: NDArray[np.float32]) -> NDArray[np.float32]:
        """Return (V, 3) float32 outward normals whose length is twice the area around each vertex.

        vertices : (V, 3) float32
        """
        for axis in range(3):
            np.take(np.ascontiguousarray(vertices[:, axis]), self._corners, out=self._positions[axis], mode="clip")
        first, second = self._edges
        np.subtract(self._positions[:, 1], self._positions[:, 0], out=first)
        np.subtract(self._positions[:, 2], self._positions[:, 0], out=second)
        for x, (y, z) in enumerate(((1, 2), (2, 0), (0, 1))):
            np.multiply(first[y], second[z], out=self._cross[x])
            np.multiply(first[z], second[y], out=self._product)
            self._cross[x] -= self._product
        self._addends[:, :3] = self._cross.T
        self._sums[:] = 0.0
        for faces in self._steps:
            self._sums[: len(faces)] += self._addends.take(faces, axis=0, mode="clip")
        return self._sums.take(self._rank, axis=0, mode="clip")[:, :3]

    def interleaved(self, vertices: NDArray[np.float32]) -> NDArray[np.float32]:
        """Return (R, 6) float32: position and normal of each render vertex. The next call overwrites the array.

        vertices : (V, 3) float32
        """
        self._welded[:, :3] = vertices[: self._count]  # a file may hold vertices that no triangle uses
        self._welded[:, 3:] = self.normals(vertices)
        np.take(self._welded, self._render_vertices, axis=0, out=self._interleaved, mode="clip")
        return self._interleaved


def _summation_steps(triangles: NDArray[np.integer], count: int) -> tuple[list[NDArray[np.intp]], NDArray[np.intp]]:
    """Return for n = 0, 1, ... the n-th triangle of each vertex that has so many, and the (V,) rank of each vertex.

    triangles : (F, 3); count : of vertices, V. Vertices with the most triangles have the first ranks.
    """
    corners = triangles.ravel()
    numbers = np.bincount(corners, minlength=count)
    faces = np.argsort(corners, kind="stable") // 3  # those of the first vertex, of the second, ...
    first = np.cumsum(numbers) - numbers
    order = np.argsort(-numbers, kind="stable")
    with_more = [np.count_nonzero(numbers > n) for n in range(int(numbers.max(initial=0)))]
    steps = [faces[first[order[:rows]] + n].astype(np.intp) for n, rows in enumerate(with_more)]
    return steps, np.argsort(order)
