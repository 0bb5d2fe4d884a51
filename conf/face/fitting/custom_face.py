"""A face of one's own: stood upright in model centimetres, its eyes, teeth and mouth found, painted if it is bare."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from conf.face.control_points import PUPILS
from conf.face.default_head import EYE_MIDDLE, default_joints, default_points
from conf.face.deformation.eyelid_helpers import helpers_on_edges
from conf.face.deformation.rig import Rig
from conf.face.deformation.rig_builder import JAW_GROUPS, RigJoints, build_rig
from conf.face.fapu import Fapu
from conf.face.fitting.default_texture import apply_default_texture
from conf.face.fitting.eyeball_insertion import insert_eyeballs
from conf.face.fitting.lip_cut import cut_lips, has_open_lips
from conf.face.fitting.part_detection import detect_parts
from conf.face.head_pose import ES0_CM
from conf.face.mesh.depth_profiles import LabelledMesh
from conf.face.mesh.editing import regroup, weld_vertices
from conf.face.mesh.mesh import Mesh
from conf.face.mesh.surface_graph import SurfaceGraph
from conf.face.similarity import SimilarityTransform, fit_similarity

MAX_POINT_DISTANCE_CM = 1.5  # half a triangle of the coarsest face
UPRIGHT = np.radians(20)  # a face that is turned less was meant so


@dataclass(frozen=True)
class PreparedFace:
    """A face made ready to be moved.

    mesh : in model centimetres; the file's vertices come first, in its order, except those of files that repeat them
    points : (n, 3) control points, model centimetres
    rig : what turns by itself
    placement : what carries the file's coordinates to model centimetres
    """

    mesh: Mesh
    points: NDArray[np.float64]
    rig: Rig
    file_to_model: SimilarityTransform


def prepare_face(mesh: Mesh, points: NDArray[np.float64], /) -> PreparedFace:
    """Make a face ready.

    mesh, points : in the file's own coordinates; points (n, 3)
    Raises ValueError if the points are no face, or lie somewhere else than the mesh.
    """
    placement = find_placement(points)
    mesh = weld_vertices(replace(mesh, vertices=placement.apply(mesh.vertices)))
    points = placement.apply(points)
    if np.median(KDTree(mesh.vertices).query(points)[0]) > MAX_POINT_DISTANCE_CM:
        raise ValueError("most of them do not lie on it; place them again with `conf fit`")
    surface = SurfaceGraph(mesh.vertices, mesh.triangles)
    if not has_open_lips(points, surface):
        mesh = cut_lips(mesh, points, surface)
    if mesh.texture is None:  # one with a picture has none for new eyes
        mesh, points = insert_eyeballs(mesh, points)
    surface = SurfaceGraph(mesh.vertices, mesh.triangles)
    anatomy = detect_parts(mesh, points, surface)
    mesh = regroup(mesh, anatomy.parts)
    if mesh.texture is None:
        mesh = apply_default_texture(mesh, points, anatomy.eyes)
    jawed = any(group in mesh.groups for group in JAW_GROUPS)
    joints = RigJoints(anatomy.eyes, _hinge(points) if jawed else None)
    shells = LabelledMesh(mesh.vertices, mesh.triangles, surface.components[mesh.triangles[:, 0]])
    rig = replace(build_rig(mesh, points, joints), margins=helpers_on_edges(points, shells))
    return PreparedFace(mesh, points, rig, placement)


def find_placement(points: NDArray[np.float64], /) -> SimilarityTransform:
    """Return what brings control points, (n, 3) of any unit and turn, to 6.4 cm between the pupils.

    The eyes come to where the default head has them. A face that lies on its back or stands on its head is turned
    upright; one that is about upright stays as it is.
    Raises ValueError if the points are no face.
    """
    try:
        eye_distance = Fapu.measure(points).es0
    except ValueError as error:
        raise ValueError("pupils, nose, lids and lips must lie apart") from error
    turn = fit_similarity(points, default_points()).rotation
    if np.trace(turn) >= 1 + 2 * np.cos(UPRIGHT):
        turn = np.eye(3)
    scale = ES0_CM / eye_distance
    return SimilarityTransform(turn, scale, EYE_MIDDLE - scale * turn @ points[PUPILS].mean(axis=0))


def _hinge(points: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]] | None:
    """Return the hinge of the jaw, where the default head has it between the same control points."""
    hinge = default_joints().hinge
    if hinge is None:
        return None
    likeness = fit_similarity(points, default_points())
    return likeness.inverse_apply(hinge[0]), hinge[1] @ likeness.rotation
