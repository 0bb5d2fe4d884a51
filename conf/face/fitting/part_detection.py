"""Find eyeballs, teeth, tongue and the inside of the mouth on a face with known control points.

Strategy. Modellers keep what moves by itself in components of their own. An eyeball is the component around a pupil
that fits a sphere; teeth and tongue are the small components behind the lips. The inside of the mouth is usually
connected with the skin: it is what can be reached from behind the lips without coming near the line between them.
"""

from dataclasses import dataclass
from typing import NamedTuple

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
from conf.face.mesh.mesh import Mesh
from conf.face.mesh.raycast import cast_front_rays
from conf.face.mesh.surface_graph import SurfaceGraph, component_labels, triangle_edges

# Model centimetres, 6.4 between the pupils; a human eyeball has a radius of 1.2.
_EYE_RADIUS = (0.7, 2.4)
_MAX_EYE_OFFSET = 1.2  # from the centre of an eyeball's bounding box to the line of sight through its pupil
_MOUTH_SIDE = 2.0  # extent of teeth and tongue beside the corners of the mouth, and relative to the line of the lips
_MOUTH_FRONT, _MOUTH_BACK = 0.3, 12.0
_MOUTH_ABOVE, _MOUTH_BELOW = 2.5, 3.5
_TONGUE_BACK = 1.2  # this far behind its front a tongue has vertices near the middle, an arch of teeth has none
_LIP_DISTANCE = 0.45  # skin nearer to the line between the lips is lip
_MIN_COVER = 0.3  # distance to what covers a vertex inside the mouth
_MOUTH_BOX = (6.0, 6.5, 13.0)  # half extents: skin reached from behind the lips farther away than this is no mouth
# Where hidden skin is sure to be inside the mouth: fraction of the half width, height above or below the line between
# the lips, nearest and farthest depth behind it.
_MOUTH_SEED_BOX = (0.5, 1.5, 0.6, 5.0)
# Relative to the radius of the eyeball.
_MAX_SPHERE_ERROR = 0.12  # root mean square distance of its vertices from the sphere
_PUPIL_DEPTH = (0.6, 1.5)  # from its centre to its pupil
_IRIS_RADIUS = 1.12  # iris and cornea, components of their own within this radius, belong to it
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
    components = _Components.of(mesh, surface)
    on_skin = surface.nearest_vertices(np.delete(points, PUPILS, axis=0), tolerance=0.3)
    skin = int(np.bincount(surface.components[on_skin]).argmax())
    assigned = {skin}
    members: dict[str, list[int]] = {}
    eyes: dict[str, NDArray[np.float64]] = {}
    for group, pupil in EYES.items():
        eyeball = _find_eyeball(components, points[CONTROL_POINT_INDEX[pupil]], assigned)
        if eyeball is not None:
            eyes[group], members[group] = eyeball
            assigned.update(members[group])
    triangle_labels = surface.components[mesh.triangles[:, 0]]
    for label in _oral_components(components, points, assigned):
        vertices = components.members(label)
        if _is_hidden(vertices, mesh, triangle_labels != label):
            members.setdefault(_mouth_group(vertices - points[_SEAM].mean(axis=0)), []).append(label)
    parts = {group: np.flatnonzero(np.isin(triangle_labels, labels)) for group, labels in members.items()}
    inside = _mouth_inside(mesh, points, surface.components == skin)
    if len(inside):
        parts["mouth"] = inside
    return DetectedParts(parts, eyes)


class _Components(NamedTuple):
    """The bounding boxes of the components, (C, 3) each, and the vertices sorted by component."""

    low: NDArray[np.float64]
    high: NDArray[np.float64]
    vertices: NDArray[np.float64]
    starts: NDArray[np.intp]

    @classmethod
    def of(cls, mesh: Mesh, surface: SurfaceGraph) -> "_Components":
        order = np.argsort(surface.components, kind="stable")
        starts = np.searchsorted(surface.components[order], np.arange(surface.components.max() + 2))
        vertices = mesh.vertices[order]
        low, high = (extreme.reduceat(vertices, starts[:-1]) for extreme in (np.minimum, np.maximum))
        return cls(low, high, vertices, starts)

    def members(self, label: int) -> NDArray[np.float64]:
        """Return the (k, 3) vertices of one component."""
        return self.vertices[self.starts[label] : self.starts[label + 1]]


def _find_eyeball(
    components: _Components, pupil: NDArray[np.float64], assigned: set[int]
) -> tuple[NDArray[np.float64], list[int]] | None:
    """Return the centre of the eyeball behind a pupil and the components it is made of."""
    centres, extent = (components.low + components.high) / 2, components.high - components.low
    near = np.linalg.norm(centres[:, :2] - pupil[:2], axis=1) < _MAX_EYE_OFFSET
    near &= (extent[:, :2] > _EYE_RADIUS[0]).all(axis=1) & (extent < 2 * _EYE_RADIUS[1]).all(axis=1)
    best: tuple[float, NDArray[np.float64]] | None = None
    for label in np.flatnonzero(near).tolist():
        if label in assigned:
            continue
        centre, radius, error = _fit_sphere(components.members(label))
        depth = np.linalg.norm(pupil - centre) / radius
        fits = _EYE_RADIUS[0] < radius < _EYE_RADIUS[1] and error < _MAX_SPHERE_ERROR * radius and centre[2] < pupil[2]
        if fits and _PUPIL_DEPTH[0] < depth < _PUPIL_DEPTH[1] and (best is None or radius > best[0]):
            best = radius, centre
    if best is None:
        return None
    reach, centre = _IRIS_RADIUS * best[0], best[1]
    corners = np.linalg.norm(np.maximum(np.abs(components.low - centre), np.abs(components.high - centre)), axis=1)
    inside = set(np.flatnonzero(corners < 2 * reach).tolist()) - assigned  # corners of a ball's box: sqrt(3) radii
    own = [i for i in sorted(inside) if np.linalg.norm(components.members(i) - centre, axis=1).max() < reach]
    return centre, own


def _fit_sphere(vertices: NDArray[np.float64]) -> tuple[NDArray[np.float64], float, float]:
    """Return centre (3,), radius and root mean square error of the linear least-squares sphere of vertices (k, 3)."""
    mean = vertices.mean(axis=0)
    offsets = vertices - mean
    system = np.column_stack([2 * offsets, np.ones(len(offsets))])
    solution = np.linalg.lstsq(system, (offsets**2).sum(axis=1), rcond=None)[0]
    radius = float(np.sqrt(max(solution[3] + solution[:3] @ solution[:3], 1e-12)))
    errors = np.linalg.norm(offsets - solution[:3], axis=1) - radius
    return mean + solution[:3], radius, float(np.sqrt((errors**2).mean()))


def _oral_components(components: _Components, points: NDArray[np.float64], assigned: set[int]) -> list[int]:
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
    if vertices[:, 1].mean() > 0:
        return "teeth_upper"
    x, _, z = vertices.T
    central = (np.abs(x) < 0.15 * max(np.ptp(x), 1.0)) & (z < z.max() - _TONGUE_BACK)
    return "tongue" if central.mean() > 0.05 else "teeth_lower"


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
    off_lips = skin & (_distance_to_seam(mesh.vertices, points) > _LIP_DISTANCE)
    edges = triangle_edges(mesh.triangles)
    labels = component_labels(edges[off_lips[edges].all(axis=1)], len(off_lips))
    reached = off_lips & np.isin(labels, labels[seeds[off_lips[seeds]]])
    if not reached.any() or (np.abs(offsets[reached]).max(axis=0) > _MOUTH_BOX).any():
        return np.empty(0, np.int64)
    return np.flatnonzero(reached[mesh.triangles].any(axis=1))


def _distance_to_seam(vertices: NDArray[np.float64], points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the (V,) distance of vertices to the nearer of the inner edges of the lips."""
    nearest = np.full(len(vertices), np.inf)
    for edge in (UPPER_LIP_EDGE, LOWER_LIP_EDGE):
        for a, b in zip(points[edge[:-1]], points[edge[1:]], strict=True):
            t = np.clip((vertices - a) @ (b - a) / max(float((b - a) @ (b - a)), 1e-12), 0.0, 1.0)
            nearest = np.minimum(nearest, np.linalg.norm(vertices - a - t[:, None] * (b - a), axis=1))
    return nearest
