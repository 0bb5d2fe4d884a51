"""Keep the inside of the mouth out of the shading of the lips.

Strategy. On a coarse mesh one row of triangles leads from the edge of a lip into the mouth. The normal of a vertex at
the edge is the mean of the triangles around it, so half of it points into the mouth, and parted lips get a light line
along their rim. A narrow row of triangles just behind the edge turns the normals instead: it adds next to no area.
"""

import numpy as np

from conf.face.mesh.edge_split import split_edges
from conf.face.mesh.mesh import Mesh
from conf.face.mesh.surface_graph import triangle_edges

# In cm, 6.4 between the pupils.
_WIDTH = 0.03  # of the row
_MIN_EDGE = 0.15  # shorter edges into the mouth are not split


def sharpen_lip_rim(mesh: Mesh, /) -> Mesh:
    """Return the mesh with a narrow row of triangles behind the border of the group "mouth".

    mesh : in model centimetres. New vertices come after those of the mesh.
    """
    if "mouth" not in mesh.groups:
        return mesh
    inside = np.zeros(len(mesh.triangles), np.bool_)
    inside[mesh.groups["mouth"]] = True
    in_mouth, on_skin = np.zeros((2, len(mesh.vertices)), np.bool_)
    in_mouth[mesh.triangles[inside]] = True
    on_skin[mesh.triangles[~inside]] = True
    rim = in_mouth & on_skin
    edges = np.unique(np.sort(triangle_edges(mesh.triangles[inside]), axis=1).astype(np.int64), axis=0)
    edges = edges[rim[edges].sum(axis=1) == 1]
    lengths = np.linalg.norm(mesh.vertices[edges[:, 0]] - mesh.vertices[edges[:, 1]], axis=1)
    edges, lengths = edges[lengths > _MIN_EDGE], lengths[lengths > _MIN_EDGE]
    fractions = _WIDTH / lengths
    return split_edges(mesh, edges, np.where(rim[edges[:, 0]], fractions, 1 - fractions))
