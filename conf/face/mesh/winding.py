"""Triangle normals and winding: some programs order the corners of all triangles clockwise."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from conf.face.mesh.mesh import Mesh
from conf.face.mesh.orientation import closed_inside_out


def triangle_normals(vertices: NDArray[np.floating], triangles: NDArray[np.integer], /) -> NDArray[np.float64]:
    """Return the (F, 3) normals of triangles (F, 3) of vertices (V, 3), each twice as long as its triangle's area."""
    a, b, c = (vertices[triangles[:, corner]] for corner in range(3))
    return np.asarray(np.cross(b - a, c - a))


def is_inside_out(vertices: NDArray[np.floating], triangles: NDArray[np.integer], /) -> bool:
    """Tell whether triangles (F, 3) of vertices (V, 3) enclose a negative volume, measured from the mean vertex."""
    a, b, c = (vertices[triangles[:, corner]] - vertices.mean(axis=0) for corner in range(3))
    return bool(np.einsum("fi,fi->", a, np.cross(b, c)) < 0)


def orient_outwards(mesh: Mesh, /) -> Mesh:
    """Return the mesh with its triangles counter-clockwise from outside: what faces inwards is not drawn.

    The whole mesh is flipped if it is inside out, and then each closed part of it that is, such as an eyeball.
    """
    whole = is_inside_out(mesh.vertices, mesh.triangles)
    triangles = mesh.triangles[:, ::-1] if whole else mesh.triangles
    flips = closed_inside_out(mesh.vertices, triangles) ^ whole
    if not flips.any():
        return mesh
    return replace(
        mesh,
        triangles=np.where(flips[:, None], mesh.triangles[:, ::-1], mesh.triangles),
        render_triangles=np.where(flips[:, None], mesh.render_triangles[:, ::-1], mesh.render_triangles),
    )
