"""Vertex normals of a deformed mesh, interleaved with the positions as the vertex buffer holds them.

The normal of a vertex is the sum of the cross products of the triangles around it in the welded mesh, so weighted by
area, and no seam of the texture shows. The sum is one sparse matrix times the triangles' cross products, because the
topology stays the same while the mesh moves.
"""

import numpy as np
from numpy.typing import NDArray
from scipy import sparse


class VertexNormals:
    """Compute the normals of one mesh; all work arrays are allocated once."""

    def __init__(self, triangles: NDArray[np.integer], render_vertices: NDArray[np.integer], /) -> None:
        """triangles : (F, 3) indices into the vertices; render_vertices : (R,) the vertex of each render vertex."""
        faces = len(triangles)
        self._count = max(int(triangles.max(initial=-1)), int(render_vertices.max())) + 1
        self._corners = np.ascontiguousarray(triangles.T, dtype=np.intp)  # (3, F)
        self._render_vertices = np.ascontiguousarray(render_vertices, dtype=np.intp)
        entries = (np.ones(3 * faces, np.float32), (np.asarray(triangles).ravel(), np.repeat(np.arange(faces), 3)))
        self._faces_to_vertices = sparse.csr_array(entries, shape=(self._count, faces))
        self._positions = np.empty((3, 3, faces), np.float32)  # axis, corner, face
        self._cross = np.empty((3, faces), np.float32)
        self._edges = np.empty((2, 3, faces), np.float32)
        self._product = np.empty(faces, np.float32)
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
        summed: NDArray[np.float32] = self._faces_to_vertices @ self._cross.T
        return summed

    def interleaved(self, vertices: NDArray[np.float32]) -> NDArray[np.float32]:
        """Return (R, 6) float32: position and normal of each render vertex. The next call overwrites the array.

        vertices : (V, 3) float32
        """
        self._welded[:, :3] = vertices[: self._count]  # a file may hold vertices that no triangle uses
        self._welded[:, 3:] = self.normals(vertices)
        np.take(self._welded, self._render_vertices, axis=0, out=self._interleaved, mode="clip")
        return self._interleaved
