"""Find eyeballs, teeth, tongue and the inside of the mouth on a face with known control points.

Strategy. Modellers keep what moves by itself in components of their own. An eyeball is the component around a pupil
that fits a sphere; teeth and tongue are the small components behind the lips. The inside of the mouth is usually
connected with the skin: it is what can be reached from behind the lips without coming near the line between them.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import (
    CONTROL_POINT_INDEX,
    LOWER_LIP_EDGE,
    PUPILS,
    UPPER_LIP_EDGE,
    control_point_indices,
)  # fmt: skip
from conf.face.deformation.rig_builder import EYES
from conf.face.fitting.eye_detection import Components, find_eyeball
from conf.face.mesh.mesh import Mesh
from conf.face.mesh.raycast import cast_front_rays
from conf.face.mesh.surface_graph import SurfaceGraph, component_labels, triangle_edges

# Model centimetres, 6.4 between the pupils.
_MOUTH_SIDE = 2.0  # extent of teeth and tongue beside the corners of the mouth, and relative to the line of the lips
_MOUTH_FRONT, _MOUTH_BACK = 0.3, 12.0
_MOUTH_ABOVE, _MOUTH_BELOW = 3.2, 3.5  # teeth with roots reach 2.7 above
_TONGUE_BACK = 1.2  # this far behind its front a tongue has vertices near the middle, an arch of teeth has none
_TONGUE_WIDTH = 1.5  # a single tooth is narrower
_GUMS_HEIGHT = 1.4  # above and below the line of the lips: only gums in one piece reach both
LIP_DISTANCE = 0.45  # skin nearer to the line between the lips is lip
_MIN_COVER = 0.3  # distance to what covers a vertex inside the mouth
_MOUTH_BOX = (6.0, 6.5, 13.0)  # half extents: skin reached from behind the lips farther away than this is no mouth
# Where hidden skin is sure to be inside the mouth: fraction of the half width, height above or below the line between
# the lips, nearest and farthest depth behind it.
_MOUTH_SEED_BOX = (0.5, 1.5, 0.6, 5.0)
_MIN_HIDDEN = 0.5  # fraction of the vertices: a component of which more is visible is a beard
_PROBES = 64  # vertices of a component that are tested for visibility

_LIPS = control_point_indices("outer_lip", "inner_lip", "cupids_bow")
_CORNERS = control_point_indices("inner_lip_corner")
_SEAM = [CONTROL_POINT_INDEX[f"inner_lip_{lip}_mid"] for lip in ("upper", "lower")]


@dataclass(frozen=True)
class DetectedParts:
    """Parts of a face.

    parts : group -> its triangles: eye_l, eye_r, teeth_upper, teeth_lower, tongue, mouth, as far as they were found
    eyes : group of an eyeball -> (3,) its centre, model centimetres
    """

    parts: dict[str, NDArray[np.int64]]
    eyes: dict[str, NDArray[np.float64]]


def detect_parts(mesh: Mesh, points: NDArray[np.float64], surface: SurfaceGraph, /) -> DetectedParts:
    """Find the parts of a face.

    mesh, points : upright, in model centimetres; points (n, 3)
    surface : of the same mesh
    """
    components = Components.of(mesh.vertices, surface.components)
    on_skin = surface.nearest_vertices(np.delete(points, PUPILS, axis=0), tolerance=0.3)
    skin = int(np.bincount(surface.components[on_skin]).argmax())
    assigned = {skin}
    members: dict[str, list[int]] = {}
    eyes: dict[str, NDArray[np.float64]] = {}
    for group, pupil in EYES.items():
        eyeball = find_eyeball(components, points[CONTROL_POINT_INDEX[pupil]], assigned)
        if eyeball is not None:
            eyes[group], members[group] = eyeball.centre, eyeball.components
            assigned.update(members[group])
    triangle_labels = surface.components[mesh.triangles[:, 0]]
    unused = set(np.setdiff1d(surface.components, triangle_labels).tolist())  # vertices without a triangle
    for label in _oral_components(components, points, assigned | unused):
        vertices = components.members(label)
        if _is_hidden(vertices, mesh, triangle_labels != label):
            members.setdefault(_mouth_group(vertices - points[_SEAM].mean(axis=0)), []).append(label)
    parts = {group: np.flatnonzero(np.isin(triangle_labels, labels)) for group, labels in members.items()}
    inside = _mouth_inside(mesh, points, surface.components == skin)
    if len(inside):
        parts["mouth"] = np.union1d(parts.get("mouth", inside), inside)
    return DetectedParts(parts, eyes)


def _oral_components(components: Components, points: NDArray[np.float64], assigned: set[int]) -> list[int]:
    """Return the components that lie where teeth and tongue do."""
    seam = points[_SEAM].mean(axis=0)
    side = np.abs(points[_CORNERS, 0] - seam[0]).max() + _MOUTH_SIDE
    low, high = components.low - seam, components.high - seam
    inside = (low[:, 0] > -side) & (high[:, 0] < side) & (high[:, 1] < _MOUTH_ABOVE) & (low[:, 1] > -_MOUTH_BELOW)
    inside &= (high[:, 2] < _MOUTH_FRONT + points[_LIPS, 2].max() - seam[2]) & (low[:, 2] > -_MOUTH_BACK)
    return [label for label in np.flatnonzero(inside).tolist() if label not in assigned]


def _is_hidden(vertices: NDArray[np.float64], mesh: Mesh, others: NDArray[np.bool_]) -> bool:
    """Tell whether the triangles in others, (F,), hide vertices (k, 3) from the viewer."""
    probes = vertices[:: max(1, len(vertices) // _PROBES)]
    depth = cast_front_rays(probes[:, :2], mesh.vertices, mesh.triangles[others]).points[:, 2]
    return bool((depth > probes[:, 2]).mean() >= _MIN_HIDDEN)


def _mouth_group(vertices: NDArray[np.float64]) -> str:
    """Return the group of a component behind the lips from its vertices (k, 3), relative to the line of the lips."""
    if vertices[:, 1].max() > _GUMS_HEIGHT and vertices[:, 1].min() < -_GUMS_HEIGHT:
        return "mouth"  # upper and lower gums in one piece
    if vertices[:, 1].mean() > 0:
        return "teeth_upper"
    x, _, z = vertices.T
    central = (np.abs(x) < 0.15 * np.ptp(x)) & (z < z.max() - _TONGUE_BACK)
    return "tongue" if central.mean() > 0.05 and np.ptp(x) > _TONGUE_WIDTH else "teeth_lower"


def _mouth_inside(mesh: Mesh, points: NDArray[np.float64], skin: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Return the (k,) triangles of the skin inside the mouth; none if there is no inside, or the lips do not bound it.

    skin : (V,) whether a vertex belongs to the skin's component
    """
    offsets = mesh.vertices - points[_SEAM].mean(axis=0)
    central = np.abs(offsets[:, 0]) < 0.5 * np.ptp(points[_CORNERS, 0]) * _MOUTH_SEED_BOX[0]
    deep = (offsets[:, 2] < -_MOUTH_SEED_BOX[2]) & (offsets[:, 2] > -_MOUTH_SEED_BOX[3])
    candidates = np.flatnonzero(skin & central & deep & (np.abs(offsets[:, 1]) < _MOUTH_SEED_BOX[1]))
    seeds = candidates[:: max(1, len(candidates) // _PROBES)]
    depth = cast_front_rays(mesh.vertices[seeds, :2], mesh.vertices, mesh.triangles).points[:, 2]
    seeds = seeds[depth > mesh.vertices[seeds, 2] + _MIN_COVER]
    off_lips = skin & (distance_to_lips(mesh.vertices, points) > LIP_DISTANCE)
    edges = triangle_edges(mesh.triangles)
    labels = component_labels(edges[off_lips[edges].all(axis=1)], len(off_lips))
    reached = off_lips & np.isin(labels, labels[seeds[off_lips[seeds]]])
    if not reached.any() or (np.abs(offsets[reached]).max(axis=0) > _MOUTH_BOX).any():
        return np.empty(0, np.int64)
    return np.flatnonzero(reached[mesh.triangles].any(axis=1))


def distance_to_lips(vertices: NDArray[np.float64], points: NDArray[np.float64], /) -> NDArray[np.float64]:
    """Return the (V,) distance of vertices to the nearer of the inner edges of the lips."""
    nearest = np.full(len(vertices), np.inf)
    for edge in (UPPER_LIP_EDGE, LOWER_LIP_EDGE):
        for a, b in zip(points[edge[:-1]], points[edge[1:]], strict=True):
            t = np.clip((vertices - a) @ (b - a) / max(float((b - a) @ (b - a)), 1e-12), 0.0, 1.0)
            nearest = np.minimum(nearest, np.linalg.norm(vertices - a - t[:, None] * (b - a), axis=1))
    return nearest
