"""From deformed vertices to what the graphics card takes: smooth normals, one row for each render vertex.

Normals are summed over the faces around each vertex of the welded mesh, weighted by area, so no seam of the texture
shows. The sum is one sparse matrix times the faces' cross products: a mesh keeps its triangles while it moves.
"""

import numpy as np
from numpy.typing import NDArray
from scipy import sparse


class VertexNormals:
    """Work space for one mesh: nothing is allocated while frames go by."""

    def __init__(self, triangles: NDArray[np.integer], render_vertices: NDArray[np.integer], /) -> None:
        """triangles : (F, 3) indices into the vertices; render_vertices : (R,) the vertex of each render vertex."""
        count = int(triangles.max()) + 1 if len(triangles) else 0
        self._count = max(count, int(render_vertices.max()) + 1)
        faces = len(triangles)
        self._corners = np.ascontiguousarray(triangles.T, dtype=np.intp)  # (3, F)
        self._render_vertices = np.ascontiguousarray(render_vertices, dtype=np.intp)
        rows = np.asarray(triangles).ravel()
        columns = np.repeat(np.arange(faces), 3)
        around = (np.ones(len(rows), np.float32), (rows, columns))
        self._faces_to_vertices = sparse.csr_array(around, shape=(self._count, faces))
        self._at = np.empty((3, 3, faces), np.float32)  # axis, corner, face
        self._cross = np.empty((3, faces), np.float32)
        self._edges = np.empty((2, 3, faces), np.float32)
        self._term = np.empty(faces, np.float32)
        self._welded = np.empty((self._count, 6), np.float32)
        self._rows = np.empty((len(render_vertices), 6), np.float32)

    def normals(self, vertices: NDArray[np.float32]) -> NDArray[np.float32]:
        """Return (V, 3) float32 normals that point outwards, as long as the area around each vertex: not unit length.

        vertices : (V, 3) float32
        """
        axes = vertices.T
        for axis in range(3):
            np.take(np.ascontiguousarray(axes[axis]), self._corners, out=self._at[axis], mode="clip")
        first, second = self._edges
        np.subtract(self._at[:, 1], self._at[:, 0], out=first)
        np.subtract(self._at[:, 2], self._at[:, 0], out=second)
        for x, (y, z) in enumerate(((1, 2), (2, 0), (0, 1))):
            np.multiply(first[y], second[z], out=self._cross[x])
            np.multiply(first[z], second[y], out=self._term)
            self._cross[x] -= self._term
        summed: NDArray[np.float32] = self._faces_to_vertices @ self._cross.T
        return summed

    def interleaved(self, vertices: NDArray[np.float32]) -> NDArray[np.float32]:
        """Return (R, 6) float32: position and normal of every render vertex. The array is used again by the next call.

        vertices : (V, 3) float32
        """
        self._welded[:, :3] = vertices[: self._count]  # a file may hold vertices that no triangle uses
        self._welded[:, 3:] = self.normals(vertices)
        np.take(self._welded, self._render_vertices, axis=0, out=self._rows, mode="clip")
        return self._rows
