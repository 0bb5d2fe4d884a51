"""Keep the inside of the mouth out of the shading of the lips.

Strategy. On a coarse mesh one row of triangles leads from the edge of a lip into the mouth. The normal of a vertex at
the edge is the mean of the triangles around it, so half of it points into the mouth, and parted lips get a light line
along their rim. A narrow row of triangles just behind the edge turns the normals instead: it adds next to no area.
"""

import numpy as np
from numpy.typing import NDArray

from conf.face.fitting.part_detection import LIP_DISTANCE, distance_to_lips
from conf.face.mesh.edge_split import split_edges
from conf.face.mesh.editing import regroup
from conf.face.mesh.mesh import Mesh
from conf.face.mesh.raycast import faces_viewer
from conf.face.mesh.surface_graph import triangle_edges
from conf.face.mesh.winding import triangle_normals

INNER_LIPS = "inner_lips"
# In cm, 6.4 between the pupils.
_WIDTH = 0.03  # of the row
_MIN_EDGE = 0.15  # shorter edges into the mouth are not split


def sharpen_lip_rim(mesh: Mesh, points: NDArray[np.float64], /) -> Mesh:
    """Return the mesh with a narrow row of triangles where its lips turn away from the viewer into the group "mouth".

    What of the lips faces away forms the group "inner_lips": it has the colour of skin, and little light reaches it.
    mesh, points : upright, in model centimetres; points (n, 3). New vertices come after those of the mesh.
    """
    if "mouth" not in mesh.groups:
        return mesh
    inside = _facing_away(mesh, points)
    lips = np.setdiff1d(np.flatnonzero(inside), mesh.groups["mouth"])
    if len(lips):
        mesh = regroup(mesh, {INNER_LIPS: lips})
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


def _facing_away(mesh: Mesh, points: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return (F,) the triangles inside the mouth, and those of the lips next to them that face away from the viewer."""
    lips = distance_to_lips(mesh.vertices, points) < LIP_DISTANCE
    away = triangle_normals(mesh.vertices, mesh.triangles)[:, 2] < 0
    if not faces_viewer(points[:, :2], mesh.vertices, mesh.triangles):
        away = ~away
    inside = np.zeros(len(mesh.triangles), np.bool_)
    inside[mesh.groups["mouth"]] = True
    while True:
        touched = np.zeros(len(mesh.vertices), np.bool_)
        touched[mesh.triangles[inside]] = True
        added = ~inside & away & (lips | touched)[mesh.triangles].all(axis=1)
        added &= touched[mesh.triangles].sum(axis=1) >= 2  # share an edge
        if not added.any():
            return inside
        inside = inside | added
