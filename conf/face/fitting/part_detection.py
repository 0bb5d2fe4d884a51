"""Find eyeballs, teeth, tongue and the inside of the mouth on a face whose control points are known.

Strategy. Modellers keep what moves by itself in shells of its own. An eyeball is the shell round a pupil that fits a
sphere; teeth and tongue are the small shells behind the lips. The inside of the mouth is usually one piece with the
skin: it is what can be reached from behind the lips without coming near the line where they meet.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from conf.face.control_points import CONTROL_POINT_INDEX, PUPILS, control_point_indices
from conf.face.deformation.rig_builder import EYES
from conf.face.mesh.mesh import Mesh
from conf.face.mesh.raycast import cast_front_rays
from conf.face.mesh.surface_graph import SurfaceGraph

# All in model centimetres, 6.4 between the pupils; a human eyeball has a radius of 1.2.
_EYE_RADIUS = (0.7, 2.4)
_MAX_EYE_OFFSET = 1.2  # from the middle of an eyeball's box to the line through its pupil
_MAX_SPHERE_ERROR = 0.12  # of the radius: root mean square distance of an eyeball's vertices from a sphere
_PUPIL_DEPTH = (0.6, 1.5)  # of the radius: from the centre of an eyeball to its pupil
_IRIS_RADIUS = 1.12  # of the radius: iris and cornea, shells of their own, go with the eyeball
_MOUTH_SIDE = 2.0  # how far the mouth reaches beyond the line between the lips: sideways from its corners,
_MOUTH_FRONT, _MOUTH_BACK = 0.3, 12.0
_MOUTH_ABOVE, _MOUTH_BELOW = 2.5, 3.5
_MIN_HIDDEN = 0.5  # of its vertices: a shell that the viewer sees more of is a beard
_PROBES = 64  # vertices of a shell that are looked at
_TONGUE_BACK = 1.2  # behind its front a tongue has a middle, an arch of teeth has none
_LIP_DISTANCE = 0.45  # what lies nearer to the line where the lips meet is lip
# Where a hidden piece of skin is sure to be the mouth's inside: within a share of half its width, above or below the
# line where the lips meet, and from so far to so far behind it.
_MOUTH_SEED_BOX = (0.5, 1.5, 0.6, 5.0)
_MIN_COVER = 0.3  # in front of it there is something else
_MOUTH_BOX = (6.0, 6.5, 13.0)  # what is reached from behind the lips farther from them than this is no mouth


@dataclass(frozen=True)
class DetectedParts:
    """What was found.

    parts : group -> its triangles: eye_l, eye_r, teeth_upper, teeth_lower, tongue, mouth, as far as they are there
    eyes : group of an eyeball -> (3,) its centre, model units
    """

    parts: dict[str, NDArray[np.int64]]
    eyes: dict[str, NDArray[np.float64]]


def detect_parts(mesh: Mesh, points: NDArray[np.float64], surface: SurfaceGraph, /) -> DetectedParts:
    """Look for the parts of a face.

    mesh, points : upright, in model centimetres; points (n, 3)
    surface : of the same mesh
    """
    shells = _Components.of(mesh, surface)
    skin = int(
        np.bincount(
            surface.components[surface.nearest_vertices(np.delete(points, PUPILS, axis=0), tolerance=0.3)]
        ).argmax()
    )
    taken = {skin}
    members: dict[str, list[int]] = {}
    eyes: dict[str, NDArray[np.float64]] = {}
    for group, pupil in EYES.items():
        ball = _find_eyeball(shells, points[CONTROL_POINT_INDEX[pupil]], taken)
        if ball is not None:
            eyes[group], members[group] = ball
            taken.update(members[group])
    of_triangle = surface.components[mesh.triangles[:, 0]]
    for shell in _oral_shells(shells, points, taken):
        places = shells.members(shell)
        if _is_hidden(places, mesh, of_triangle != shell):
            members.setdefault(_mouth_group(places - points[_SEAM].mean(axis=0)), []).append(shell)
    parts = {group: np.flatnonzero(np.isin(of_triangle, chosen)) for group, chosen in members.items()}
    inside = _mouth_inside(mesh, points, surface.components == skin)
    if len(inside):
        parts["mouth"] = inside
    return DetectedParts(parts, eyes)


class _Components(NamedTuple):
    """Every shell's box, (S, 3) each, and the vertices with the shell each is in, sorted by it."""

    low: NDArray[np.float64]
    high: NDArray[np.float64]
    vertices: NDArray[np.float64]
    starts: NDArray[np.intp]

    @classmethod
    def of(cls, mesh: Mesh, surface: SurfaceGraph) -> "_Components":
        order = np.argsort(surface.components, kind="stable")
        starts = np.searchsorted(surface.components[order], np.arange(surface.components.max() + 2))
        sorted_vertices = mesh.vertices[order]
        low = np.minimum.reduceat(sorted_vertices, starts[:-1])
        return cls(low, np.maximum.reduceat(sorted_vertices, starts[:-1]), sorted_vertices, starts)

    def members(self, shell: int) -> NDArray[np.float64]:
        """Return the (k, 3) vertices of one shell."""
        return self.vertices[self.starts[shell] : self.starts[shell + 1]]


def _find_eyeball(
    shells: _Components, pupil: NDArray[np.float64], taken: set[int]
) -> tuple[NDArray[np.float64], list[int]] | None:
    """Return the centre of the eyeball behind a pupil and the shells it is made of."""
    middle, extent = (shells.low + shells.high) / 2, shells.high - shells.low
    near = np.linalg.norm(middle[:, :2] - pupil[:2], axis=1) < _MAX_EYE_OFFSET
    near &= (extent[:, :2] > _EYE_RADIUS[0]).all(axis=1) & (extent < 2 * _EYE_RADIUS[1]).all(axis=1)
    best: tuple[float, NDArray[np.float64]] | None = None
    for shell in np.flatnonzero(near).tolist():
        if shell in taken:
            continue
        centre, radius, error = _fit_sphere(shells.members(shell))
        depth = np.linalg.norm(pupil - centre) / radius
        fits = _EYE_RADIUS[0] < radius < _EYE_RADIUS[1] and error < _MAX_SPHERE_ERROR * radius and centre[2] < pupil[2]
        if fits and _PUPIL_DEPTH[0] < depth < _PUPIL_DEPTH[1] and (best is None or radius > best[0]):
            best = radius, centre
    if best is None:
        return None
    radius, centre = best
    farthest = np.linalg.norm(np.maximum(np.abs(shells.low - centre), np.abs(shells.high - centre)), axis=1)
    inside = np.flatnonzero(
        farthest < 2 * _IRIS_RADIUS * radius
    ).tolist()  # of the corners of a box round a ball: sqrt 3
    reach = _IRIS_RADIUS * radius
    own = [s for s in inside if s not in taken and np.linalg.norm(shells.members(s) - centre, axis=1).max() < reach]
    return centre, own


def _fit_sphere(places: NDArray[np.float64]) -> tuple[NDArray[np.float64], float, float]:
    """Return centre (3,), radius and root mean square error of the sphere nearest to places (k, 3), linearly."""
    middle = places.mean(axis=0)
    around = places - middle
    system = np.column_stack([2 * around, np.ones(len(around))])
    solution = np.linalg.lstsq(system, (around**2).sum(axis=1), rcond=None)[0]
    radius = float(np.sqrt(max(solution[3] + solution[:3] @ solution[:3], 1e-12)))
    errors = np.linalg.norm(around - solution[:3], axis=1) - radius
    return middle + solution[:3], radius, float(np.sqrt((errors**2).mean()))


def _oral_shells(shells: _Components, points: NDArray[np.float64], taken: set[int]) -> list[int]:
    """Return the shells that lie where teeth and tongue do."""
    line = points[_SEAM].mean(axis=0)
    wide = np.abs(points[_CORNERS, 0] - line[0]).max() + _MOUTH_SIDE
    low, high = shells.low - line, shells.high - line
    inside = (low[:, 0] > -wide) & (high[:, 0] < wide) & (high[:, 1] < _MOUTH_ABOVE) & (low[:, 1] > -_MOUTH_BELOW)
    inside &= (high[:, 2] < _MOUTH_FRONT + points[_LIPS, 2].max() - line[2]) & (low[:, 2] > -_MOUTH_BACK)
    return [shell for shell in np.flatnonzero(inside).tolist() if shell not in taken]


def _is_hidden(places: NDArray[np.float64], mesh: Mesh, others: NDArray[np.bool_]) -> bool:
    """Say whether the triangles of others, (F,), hide places (k, 3) from the viewer."""
    probes = places[:: max(1, len(places) // _PROBES)]
    depth = cast_front_rays(probes[:, :2], mesh.vertices, mesh.triangles[others]).points[:, 2]
    return bool((depth > probes[:, 2]).mean() >= _MIN_HIDDEN)


def _mouth_group(places: NDArray[np.float64]) -> str:
    """Say what a shell behind the lips is from its vertices (k, 3), the line of the lips at zero."""
    if places[:, 1].mean() > 0:
        return "teeth_upper"
    x, _, z = places.T
    in_the_middle = (np.abs(x) < 0.15 * max(np.ptp(x), 1.0)) & (z < z.max() - _TONGUE_BACK)
    return "tongue" if in_the_middle.mean() > 0.05 else "teeth_lower"


def _mouth_inside(mesh: Mesh, points: NDArray[np.float64], skin: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Return the triangles of the skin that are the mouth's inside, (k,); none if it has none or no line parts it."""
    off = mesh.vertices - points[_SEAM].mean(axis=0)
    half = np.abs(off[:, 0]) < 0.5 * np.ptp(points[_CORNERS, 0]) * _MOUTH_SEED_BOX[0]
    deep = (off[:, 2] < -_MOUTH_SEED_BOX[2]) & (off[:, 2] > -_MOUTH_SEED_BOX[3])
    likely = np.flatnonzero(skin & half & deep & (np.abs(off[:, 1]) < _MOUTH_SEED_BOX[1]))
    sure = likely[:: max(1, len(likely) // _PROBES)]
    depth = cast_front_rays(mesh.vertices[sure, :2], mesh.vertices, mesh.triangles).points[:, 2]
    sure = sure[depth > mesh.vertices[sure, 2] + _MIN_COVER]
    free = skin & (_distance_to_seam(mesh.vertices, points) > _LIP_DISTANCE)
    edges = mesh.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    edges = edges[free[edges].all(axis=1)]
    graph = coo_array((np.ones(len(edges), np.int8), edges.T), shape=(len(free), len(free)))
    pieces = connected_components(graph, directed=False)[1]
    reached = free & np.isin(pieces, pieces[sure[free[sure]]])
    if not reached.any() or (np.abs(off[reached]).max(axis=0) > _MOUTH_BOX).any():
        return np.empty(0, np.int64)
    return np.flatnonzero(reached[mesh.triangles].any(axis=1))


def _distance_to_seam(places: NDArray[np.float64], points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the (V,) distance of places to the lines where the lips meet, upper and lower."""
    nearest = np.full(len(places), np.inf)
    for way in (_UPPER, _LOWER):
        for a, b in zip(points[way[:-1]], points[way[1:]], strict=True):
            along = np.clip((places - a) @ (b - a) / max(float((b - a) @ (b - a)), 1e-12), 0.0, 1.0)
            nearest = np.minimum(nearest, np.linalg.norm(places - a - along[:, None] * (b - a), axis=1))
    return nearest


_SEAM = [CONTROL_POINT_INDEX[f"inner_lip_{lip}_mid"] for lip in ("upper", "lower")]
_CORNERS = control_point_indices("inner_lip_corner")
_LIPS = control_point_indices("outer_lip", "inner_lip", "cupids_bow")
_UPPER, _LOWER = (
    [
        CONTROL_POINT_INDEX[f"inner_lip_{place}"]
        for place in ("corner_r", f"{lip}_r", f"{lip}_mid", f"{lip}_l", "corner_l")
    ]
    for lip in ("upper", "lower")
)
