"""Fit the control points to the surface of a mesh, starting from the observed landmarks.

Everything here is in the frame of the face prior: centimetres, facing the viewer.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_INDEX, PUPILS
from conf.face.fitting.eye_detection import without_eye_covers
from conf.face.fitting.face_prior import FacePrior
from conf.face.fitting.lip_cut import has_open_lips
from conf.face.mesh.depth_profiles import LabelledMesh, find_lid_edge, find_lip_line
from conf.face.mesh.raycast import cast_front_rays, faces_viewer, nearest_points
from conf.face.mesh.surface_graph import SurfaceGraph, component_labels, triangle_edges

# All in cm.
_MAX_DISTANCE = 1.5  # from a predicted point to the surface
_EYE_SIZE = (1.6, 4.5)  # width and height of an eyeball
_MAX_PUPIL_OFFSET = 0.8  # from the predicted pupil to the axis of its eyeball
_MAX_LIP_MOVE = 0.4  # of a lip point to a vertex of its own lip
_LIP_SEARCH = 4.0  # along the skin around a lip
_SKIN_TOLERANCE = 0.3  # by which the skin may be farther than another component
_PUPIL_HEIGHT = 0.62  # from the lower lid (0) to the upper (1), as on the default head

_LIP_PAIRS = [[CONTROL_POINT_INDEX[f"inner_lip_{lip}_{at}"] for lip in ("upper", "lower")] for at in ("mid", "l", "r")]
_OUTER_LIPS = [[CONTROL_POINT_INDEX[f"outer_lip_{lip}_{at}"] for at in ("mid", "l", "r")] for lip in ("upper", "lower")]
_LIDS = [
    [CONTROL_POINT_INDEX[f"{name}_{side}"] for name in (f"eyelid_{lid}", "pupil")]
    for lid in ("upper", "lower")
    for side in "lr"
]


@dataclass(frozen=True)
class FittedPoints:
    """Control points on a mesh and the features they were fitted to.

    points : (n, 3)
    lip_lines : at how many of three positions the line between the lips was found
    lid_edges : of how many of four lids the edge was found
    eyeballs : how many eyes are components of their own
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
    """Find the (n, 3) control points of a mesh (V, 3), (F, 3) from observed landmarks (m, 3)."""
    predicted = prior.predict_points(observed, vertices, triangles)
    if not faces_viewer(predicted[:, :2], vertices, triangles):
        triangles = np.ascontiguousarray(triangles[:, ::-1])
    triangles = triangles[without_eye_covers(vertices, triangles, predicted[PUPILS])]
    labels = component_labels(triangle_edges(triangles), len(vertices))
    mesh = LabelledMesh(vertices, triangles, labels[triangles[:, 0]])
    points = nearest_points(predicted, prior.normals, vertices, triangles, reach=_MAX_DISTANCE)
    points = np.where(np.isnan(points), predicted, points)
    eyeballs = _fit_pupils(points, predicted, mesh)
    lip_lines = _fit_lips(points, mesh)
    lid_edges = _fit_lids(points, mesh)
    for side in eyeballs:
        _centre_pupil(points, side, mesh)
    surface = SurfaceGraph(vertices, triangles)
    _separate_lips(points, vertices, surface)
    return FittedPoints(points, lip_lines, lid_edges, len(eyeballs), has_open_lips(points, surface))


def _fit_pupils(points: NDArray[np.float64], predicted: NDArray[np.float64], mesh: LabelledMesh) -> list[str]:
    """Set the pupils to the fronts of the eyeballs, or to the prediction; return the sides with an eyeball."""
    found = []
    for side in "lr":
        row = CONTROL_POINT_INDEX[f"pupil_{side}"]
        pupil = points[row] = predicted[row]
        hit = cast_front_rays(pupil[None, :2], mesh.vertices, mesh.triangles).triangles[0]
        if hit < 0:
            continue
        component = mesh.triangles[mesh.triangle_labels == mesh.triangle_labels[hit]]
        eyeball = mesh.vertices[component].reshape(-1, 3)
        low, high = eyeball.min(axis=0), eyeball.max(axis=0)
        front = np.array([*(low + high)[:2] / 2, high[2]])
        size = (high - low)[:2]
        if (size > _EYE_SIZE[0]).all() and (size < _EYE_SIZE[1]).all():
            if np.linalg.norm((front - pupil)[:2]) < _MAX_PUPIL_OFFSET:
                points[row] = front
                found.append(side)
    return found


def _centre_pupil(points: NDArray[np.float64], side: str, mesh: LabelledMesh) -> None:
    """Move a pupil along its eyeball to its height between the lids of an eye at rest: the head may be tilted."""
    row = CONTROL_POINT_INDEX[f"pupil_{side}"]
    upper, lower = (points[CONTROL_POINT_INDEX[f"eyelid_{lid}_{side}"], 1] for lid in ("upper", "lower"))
    ray = np.array([[points[row, 0], lower + _PUPIL_HEIGHT * (upper - lower)]])
    hit = cast_front_rays(ray, mesh.vertices, mesh.triangles).points[0]
    if upper > lower and abs(hit[2] - points[row, 2]) < _MAX_PUPIL_OFFSET:  # False for nan, a miss
        points[row] = hit


def _fit_lips(points: NDArray[np.float64], mesh: LabelledMesh) -> int:
    """Move the inner lip points to the line between the lips; return at how many positions it was found."""
    found = 0
    for pair in _LIP_PAIRS:
        line = find_lip_line(mesh, points[pair].mean(axis=0))
        if line is not None:
            points[pair] = line
            found += 1
    return found


def _fit_lids(points: NDArray[np.float64], mesh: LabelledMesh) -> int:
    """Move the lid points to the edges of the lids; return how many were found."""
    found = 0
    for lid, pupil in _LIDS:
        edge = find_lid_edge(mesh, points[lid], points[pupil, 1])
        if edge is not None:
            points[lid] = edge
            found += 1
    return found


def _separate_lips(points: NDArray[np.float64], vertices: NDArray[np.float64], surface: SurfaceGraph) -> None:
    """Move each inner lip point to a near vertex of its own lip: where lips touch, it may lie on the other."""
    seeds = (surface.nearest_vertices(points[lip], tolerance=_SKIN_TOLERANCE) for lip in _OUTER_LIPS)
    to_upper, to_lower = (surface.distances(lip, limit=_LIP_SEARCH) for lip in seeds)
    for column, own, other in ((0, to_upper, to_lower), (1, to_lower, to_upper)):
        lip = np.flatnonzero(own < other)
        for pair in _LIP_PAIRS:
            distance = np.linalg.norm(vertices[lip] - points[pair[column]], axis=1)
            if len(lip) and distance.min() < _MAX_LIP_MOVE:
                points[pair[column]] = vertices[lip[distance.argmin()]]
