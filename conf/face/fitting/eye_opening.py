"""Cut the eyes open on a face whose surface runs on between the lids: a mask, or a scan with the eyes in one piece.

Strategy. The lids are two parabolas from corner to corner through the lid points. Triangles there are made small, cut
along the parabolas, and what lies between these is removed. An eyeball is put behind the opening afterwards.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_INDEX
from conf.face.fitting.eye_detection import Components, find_eyeball
from conf.face.fitting.painted_eyes import image_between_lids
from conf.face.mesh.edge_split import drop_triangles, split_edges
from conf.face.mesh.mesh import Mesh
from conf.face.mesh.raycast import cast_front_rays
from conf.face.mesh.surface_graph import SurfaceGraph, triangle_edges
from conf.face.mesh.winding import triangle_normals

# Model centimetres, 6.4 between the pupils.
_MAX_EDGE = 0.2  # of the triangles that are cut
_REFINEMENTS = 4  # halvings of longer edges, at most
_MARGIN = 0.1  # around the opening, in which edges are halved: coarse skin beyond it keeps its smooth shading
_MAX_DEPTH = 1.0  # from the lids to the surface between them: what is deeper is a socket
_MIN_HEIGHT = 0.35  # of an opening: lids that are closed stay closed
_SKIN_TOLERANCE = 0.3  # by which the skin may be farther from the corners of an eye than another part
_TOLERANCE = 0.02  # vertices nearer than this to a lid's edge count as outside


def open_eyes(mesh: Mesh, points: NDArray[np.float64], /) -> Mesh:
    """Return the mesh with an opening between the lids of each eye that has no eyeball and no socket.

    Eyes that are a textured part of their own, such as those of a cartoon, stay as they are.
    mesh, points : upright, in model centimetres; points (n, 3). New vertices come after those of the mesh.
    """
    for side in "lr":
        names = ("eye_outer_corner", "eyelid_upper", "eyelid_lower", "eye_inner_corner")
        outer, upper, lower, inner = points[[CONTROL_POINT_INDEX[f"{name}_{side}"] for name in names]]
        pupil = points[CONTROL_POINT_INDEX[f"pupil_{side}"]]
        middle = (upper + lower) / 2
        hit = cast_front_rays(middle[None, :2], mesh.vertices, mesh.triangles)
        depth, triangle = hit.points[0, 2], int(hit.triangles[0])
        if not depth > middle[2] - _MAX_DEPTH or upper[1] - lower[1] < _MIN_HEIGHT:  # also True for nan, a miss
            continue
        surface = SurfaceGraph(mesh.vertices, mesh.triangles)
        skin = surface.components[surface.nearest_vertices(np.stack([outer, inner]), tolerance=_SKIN_TOLERANCE)]
        if image_between_lids(mesh, points, side) >= 0 and surface.components[mesh.triangles[triangle, 0]] not in skin:
            continue
        components = Components.of(mesh.vertices, surface.components)
        if find_eyeball(components, pupil, set()) is None:
            mesh = _cut(mesh, np.stack([outer, upper, inner]), np.stack([outer, lower, inner]))
    return mesh


def _cut(mesh: Mesh, upper: NDArray[np.float64], lower: NDArray[np.float64]) -> Mesh:
    """Remove what lies between two parabolas through three points, (3, 3) each."""
    for _ in range(_REFINEMENTS):
        edges = _edges_near(mesh, upper, lower)
        lengths = np.linalg.norm(mesh.vertices[edges[:, 0]] - mesh.vertices[edges[:, 1]], axis=1)
        reach = _height_inside(mesh.vertices, upper, lower)[edges].max(axis=1)
        middle = _height_inside(mesh.vertices[edges].mean(axis=1), upper, lower)
        edges = edges[(lengths > _MAX_EDGE) & (np.maximum(reach, middle) > -_MARGIN)]
        middles = _smooth_middles(mesh, edges)
        mesh = split_edges(mesh, edges, np.full(len(edges), 0.5))
        vertices = mesh.vertices.copy()
        vertices[len(vertices) - len(edges) :] = middles
        mesh = replace(mesh, vertices=vertices)
    inside = _height_inside(mesh.vertices, upper, lower) - _TOLERANCE
    edges = _edges_near(mesh, upper, lower)
    first, second = inside[edges].T
    crossing = (first > 0) != (second > 0)
    first, second = first[crossing], second[crossing]
    count = len(mesh.vertices)
    mesh = split_edges(mesh, edges[crossing], first / (first - second))
    inside = np.concatenate([inside, np.zeros(len(mesh.vertices) - count)])[mesh.triangles]
    return drop_triangles(mesh, (inside.max(axis=1) > 0) & (inside.min(axis=1) >= 0) & _near(mesh, upper, lower))


def _smooth_middles(mesh: Mesh, edges: NDArray[np.int64]) -> NDArray[np.float64]:
    """Return the (k, 3) middles of edges on a smooth surface through the vertices.

    Source: Vlachos et al. 2001, curved PN triangles.
    """
    normals = np.zeros_like(mesh.vertices)
    for corner in range(3):
        np.add.at(normals, mesh.triangles[:, corner], triangle_normals(mesh.vertices, mesh.triangles))
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
    (a, b), (normal_a, normal_b) = mesh.vertices[edges.T], normals[edges.T]
    along_a = ((b - a) * normal_a).sum(axis=1, keepdims=True) * normal_a
    along_b = ((a - b) * normal_b).sum(axis=1, keepdims=True) * normal_b
    return np.asarray((a + b) / 2 - (along_a + along_b) / 8)


def _height_inside(
    vertices: NDArray[np.float64], upper: NDArray[np.float64], lower: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the (V,) distance of each vertex from the nearer lid, positive between the lids."""
    outer, inner = upper[0], upper[2]
    t = (vertices[:, 0] - outer[0]) / (inner[0] - outer[0])
    above = vertices[:, 1] - (outer[1] + t * (inner[1] - outer[1]))  # the line through the corners
    arc = 4 * t * (1 - t)  # a lid point beside the middle must not lift the parabola beyond it
    upper_height, lower_height = (
        lid[1, 1] - outer[1] - (lid[1, 0] - outer[0]) / (inner[0] - outer[0]) * (inner[1] - outer[1])
        for lid in (upper, lower)
    )
    return np.asarray(np.minimum(upper_height * arc - above, above - lower_height * arc))


def _near(mesh: Mesh, upper: NDArray[np.float64], lower: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return (F,) which triangles reach into the box around the lids, not as deep as the back of the head."""
    lids = np.concatenate([upper, lower])
    low, high = lids.min(axis=0) - _MARGIN, lids.max(axis=0) + _MARGIN
    low[2] -= _MAX_DEPTH
    high[2] += _MAX_DEPTH
    corners = mesh.vertices[mesh.triangles]
    return np.asarray(((corners.max(axis=1) > low) & (corners.min(axis=1) < high)).all(axis=1))


def _edges_near(mesh: Mesh, upper: NDArray[np.float64], lower: NDArray[np.float64]) -> NDArray[np.int64]:
    """Return the (k, 2) edges of the triangles near the lids."""
    edges = np.sort(triangle_edges(mesh.triangles[_near(mesh, upper, lower)]), axis=1)
    return np.unique(edges.astype(np.int64), axis=0)
