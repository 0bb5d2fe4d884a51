"""Put the control points where they belong on a mesh, from where the tracker saw them.

Everything here is in the frame of the face prior: centimetres, the face looks at the viewer.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_INDEX, LOWER_LIP, UPPER_LIP
from conf.face.fitting.face_prior import FacePrior
from conf.face.fitting.lip_cut import has_open_lips
from conf.face.mesh.depth_profiles import LabelledMesh, find_lid_edge, find_lip_line
from conf.face.mesh.raycast import cast_front_rays, faces_viewer, nearest_points
from conf.face.mesh.surface_graph import SurfaceGraph, component_labels, triangle_edges

_MAX_DISTANCE = 1.5  # cm from the likely shape that the surface is looked for
_LIP_PAIRS = [(f"inner_lip_upper_{side}", f"inner_lip_lower_{side}") for side in ("mid", "l", "r")]
_LIDS = [(f"eyelid_{lid}_{side}", f"pupil_{side}") for lid in ("upper", "lower") for side in "lr"]
_EYE_SIZE = (1.6, 4.5)  # cm across an eyeball
_MAX_PUPIL_OFFSET = 0.8  # cm from the likely pupil that an eyeball's axis may lie
_PUPIL_HEIGHT = 0.62  # of the way from the lower lid to the upper, as on the default head
_MAX_LIP_MOVE = 0.4  # cm that a lip point may move to a vertex of its own lip
_LIP_SEARCH = 4.0  # cm along the skin that is looked at around a lip
_SKIN_TOLERANCE = 0.3  # cm that the skin may be farther than another shell


@dataclass(frozen=True)
class FittedPoints:
    """Control points on a mesh and what was found of the features they mark.

    points : (n, 3)
    lip_lines : at how many of three places the lips were seen to meet or part
    lid_edges : of how many of four lids the edge was seen
    eyeballs : how many eyes are shells of their own
    mouth_open : whether the mesh is cut between the lips
    """

    points: NDArray[np.float64]
    lip_lines: int
    lid_edges: int
    eyeballs: int
    mouth_open: bool


def fit_control_points(
    observed: NDArray[np.float64], vertices: NDArray[np.float64], triangles: NDArray[np.int32], prior: FacePrior
) -> FittedPoints:
    """Find the (n, 3) control points of a mesh (V, 3), (F, 3) from where the tracker saw them, (m, 3)."""
    shape = prior.predict_points(observed, vertices, triangles)
    if not faces_viewer(shape[:, :2], vertices, triangles):
        triangles = np.ascontiguousarray(triangles[:, ::-1])
    shells = LabelledMesh(
        vertices, triangles, component_labels(triangle_edges(triangles), len(vertices))[triangles[:, 0]]
    )
    points = nearest_points(shape, prior.normals, vertices, triangles, reach=_MAX_DISTANCE)
    points = np.where(np.isnan(points), shape, points)
    balls = _fit_pupils(points, shape, shells)
    lines = _fit_lips(points, shells)
    edges = _fit_lids(points, shells)
    for pupil in balls:
        _centre_pupil(points, pupil, shells)
    surface = SurfaceGraph(vertices, triangles)
    _separate_lips(points, vertices, surface)
    return FittedPoints(points, lines, edges, len(balls), has_open_lips(points, surface))


def _fit_pupils(points: NDArray[np.float64], shape: NDArray[np.float64], shells: LabelledMesh) -> list[str]:
    """Put pupils on the fronts of the eyeballs, or where they would be if there are none; return those on eyeballs."""
    found = []
    for name in ("pupil_l", "pupil_r"):
        pupil = shape[CONTROL_POINT_INDEX[name]]
        points[CONTROL_POINT_INDEX[name]] = pupil
        hit = cast_front_rays(pupil[None, :2], shells.vertices, shells.triangles).triangles[0]
        if hit < 0:
            continue
        ball = shells.vertices[shells.triangles[shells.triangle_labels == shells.triangle_labels[hit]]].reshape(-1, 3)
        low, high = ball.min(axis=0), ball.max(axis=0)
        front = np.array([*(low + high)[:2] / 2, high[2]])
        across = (high - low)[:2]
        if (across > _EYE_SIZE[0]).all() and (across < _EYE_SIZE[1]).all():
            if np.linalg.norm((front - pupil)[:2]) < _MAX_PUPIL_OFFSET:
                points[CONTROL_POINT_INDEX[name]] = front
                found.append(name)
    return found


def _centre_pupil(points: NDArray[np.float64], pupil: str, shells: LabelledMesh) -> None:
    """Move a pupil along its eyeball to where an eye at rest has it between its lids: the head may be held high."""
    upper, lower = (points[CONTROL_POINT_INDEX[f"eyelid_{lid}_{pupil[-1]}"], 1] for lid in ("upper", "lower"))
    place = np.array([[points[CONTROL_POINT_INDEX[pupil], 0], lower + _PUPIL_HEIGHT * (upper - lower)]])
    seen = cast_front_rays(place, shells.vertices, shells.triangles).points[0]
    if upper > lower and abs(seen[2] - points[CONTROL_POINT_INDEX[pupil], 2]) < _MAX_PUPIL_OFFSET:  # nan is not
        points[CONTROL_POINT_INDEX[pupil]] = seen


def _fit_lips(points: NDArray[np.float64], shells: LabelledMesh) -> int:
    found = 0
    for upper, lower in _LIP_PAIRS:
        line = find_lip_line(shells, points[[CONTROL_POINT_INDEX[upper], CONTROL_POINT_INDEX[lower]]].mean(axis=0))
        if line is not None:
            points[CONTROL_POINT_INDEX[upper]], points[CONTROL_POINT_INDEX[lower]] = line
            found += 1
    return found


def _fit_lids(points: NDArray[np.float64], shells: LabelledMesh) -> int:
    found = 0
    for lid, pupil in _LIDS:
        edge = find_lid_edge(shells, points[CONTROL_POINT_INDEX[lid]], points[CONTROL_POINT_INDEX[pupil], 1])
        if edge is not None:
            points[CONTROL_POINT_INDEX[lid]] = edge
            found += 1
    return found


def _separate_lips(points: NDArray[np.float64], vertices: NDArray[np.float64], surface: SurfaceGraph) -> None:
    """Move the inner lip points to vertices of their own lip, where one is near: touching lips are easily confused."""
    outer = [[i for i in lip if i in _OUTER_LIPS] for lip in (UPPER_LIP, LOWER_LIP)]
    to_upper, to_lower = (
        surface.distances(surface.nearest_vertices(points[group], tolerance=_SKIN_TOLERANCE), limit=_LIP_SEARCH)
        for group in outer
    )
    for names, own, other in ((0, to_upper, to_lower), (1, to_lower, to_upper)):
        side = np.flatnonzero(own < other)
        for pair in _LIP_PAIRS:
            index = CONTROL_POINT_INDEX[pair[names]]
            away = np.linalg.norm(vertices[side] - points[index], axis=1)
            if len(side) and away.min() < _MAX_LIP_MOVE:
                points[index] = vertices[side[away.argmin()]]


_OUTER_LIPS = [
    CONTROL_POINT_INDEX[f"outer_lip_{lip}_{side}"] for lip in ("upper", "lower") for side in ("mid", "l", "r")
]
