"""Prepare a user's mesh: upright in model centimetres, with its eyes, teeth and mouth found, textured if it is not."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from conf.face.control_points import PUPILS
from conf.face.default_head import EYE_MIDPOINT, default_joints, default_points
from conf.face.deformation.eyelid_helpers import helpers_on_edges, with_brow_helpers
from conf.face.deformation.rig import Rig
from conf.face.deformation.rig_builder import JAW_GROUPS, RIGID_GROUPS, RigJoints, build_rig
from conf.face.fapu import Fapu
from conf.face.fitting.default_texture import apply_default_texture
from conf.face.fitting.eye_detection import without_eye_covers
from conf.face.fitting.eye_opening import open_eyes
from conf.face.fitting.eyeball_insertion import insert_eyeballs
from conf.face.fitting.lip_cut import cut_lips, has_open_lips
from conf.face.fitting.lip_rim import sharpen_lip_rim
from conf.face.fitting.mouth_cavity import add_mouth_cavity
from conf.face.fitting.painted_eyes import keep_painted_eyes
from conf.face.fitting.part_detection import DetectedParts, detect_parts
from conf.face.fitting.teeth_insertion import complete_teeth
from conf.face.formats.mtl import MeshMaterial
from conf.face.head_pose import ES0_CM
from conf.face.mesh.depth_profiles import LabelledMesh
from conf.face.mesh.edge_split import drop_triangles
from conf.face.mesh.editing import regroup, weld_vertices
from conf.face.mesh.mesh import Mesh
from conf.face.mesh.orientation import weld_indices
from conf.face.mesh.raycast import faces_viewer
from conf.face.mesh.surface_graph import SurfaceGraph
from conf.face.similarity import SimilarityTransform, fit_similarity

MAX_POINT_DISTANCE_CM = 1.5  # median from point to vertex; half a triangle of the coarsest face
MAX_TILT = np.radians(20)  # a face rotated by less stays as it is


@dataclass(frozen=True)
class PreparedFace:
    """A face ready to be deformed.

    mesh : in model centimetres; the file's vertices come first, in its order, except those of files that repeat them
    points : (n, 3) control points, model centimetres
    file_to_model : from the file's coordinates to model centimetres
    remarks : which parts were not found, and what was done about each
    """

    mesh: Mesh
    points: NDArray[np.float64]
    rig: Rig
    file_to_model: SimilarityTransform
    remarks: tuple[str, ...] = ()


def prepare_face(mesh: Mesh, points: NDArray[np.float64], /) -> PreparedFace:
    """Prepare a face.

    mesh, points : in the file's coordinates; points (n, 3)
    Raises ValueError if the points are not those of a face, or do not lie on the mesh.
    """
    file_to_model = find_file_to_model(points)
    mesh = weld_vertices(replace(mesh, vertices=file_to_model.apply(mesh.vertices)))
    points = file_to_model.apply(points)
    if np.median(KDTree(mesh.vertices).query(points)[0]) > MAX_POINT_DISTANCE_CM:
        raise ValueError("most of them do not lie on it; place them again with `conf fit`")
    texture = mesh.texture
    mesh, points, detected, remarks = _complete(_without_false_parts(_with_texture_as_material(mesh)), points)
    surface = SurfaceGraph(mesh.vertices, mesh.triangles)
    if texture is None or (mesh.materials_of_triangles() < 0).any():  # parts without a material: put in
        mesh = apply_default_texture(mesh, points, detected.eyes)
    else:
        mesh = replace(mesh, texture=texture, materials=(), triangle_materials=None)
    has_jaw = any(group in mesh.groups for group in JAW_GROUPS)
    rig = build_rig(mesh, points, RigJoints(detected.eyes, _find_hinge(points) if has_jaw else None))
    labelled = LabelledMesh(mesh.vertices, mesh.triangles, surface.components[mesh.triangles[:, 0]])
    rig = replace(rig, eyelid_helpers=with_brow_helpers(helpers_on_edges(points, labelled), points, labelled))
    return PreparedFace(mesh, points, rig, file_to_model, tuple(remarks))


def _complete(mesh: Mesh, points: NDArray[np.float64]) -> tuple[Mesh, NDArray[np.float64], DetectedParts, list[str]]:
    """Return the mesh with its parts found, and with those put in that are missing; the points; what was missing."""
    remarks: list[str] = []
    has_images = any(material.image is not None or material.alpha < 1 for material in mesh.materials)
    if not has_images:  # with a texture, what covers the eyes may be transparent
        kept = without_eye_covers(mesh.vertices, mesh.triangles, points[PUPILS])
        if not kept.all():
            remarks.append("tear film or lashes cover the eyes: they are not drawn, as there is no transparent texture")
            mesh = drop_triangles(mesh, ~kept)
    surface = SurfaceGraph(mesh.vertices, mesh.triangles)
    if not has_open_lips(points, surface):
        mesh = cut_lips(mesh, points, surface)
    painted = mesh
    opened = open_eyes(mesh, points)
    if opened is not mesh:
        remarks.append("no opening between the lids: cut open")
    mesh, points = insert_eyeballs(opened, points)
    if len(mesh.vertices) > len(opened.vertices):
        remarks.append("no eyeballs: put in")
    surface = SurfaceGraph(mesh.vertices, mesh.triangles)
    detected = detect_parts(mesh, points, surface)
    mesh = keep_painted_eyes(regroup(mesh, detected.parts), painted, points, detected.eyes)
    if len(detected.eyes) < len(PUPILS):
        remarks.append("no eyeballs: the eyes cannot turn")
    if "mouth" not in mesh.groups:
        mesh = add_mouth_cavity(mesh, points)
        is_added = "mouth" in mesh.groups
        remarks.append("no inside of the mouth: " + ("put in" if is_added else "an open mouth may show a hole"))
    mesh = sharpen_lip_rim(mesh, points)
    mesh, remark = complete_teeth(mesh, points, outwards=faces_viewer(points[:, :2], mesh.vertices, mesh.triangles))
    return mesh, points, detected, remarks if remark is None else [*remarks, remark]


def _with_texture_as_material(mesh: Mesh) -> Mesh:
    """Return the mesh with its one texture as a material of all triangles, so that added parts can have another."""
    if mesh.texture is None:
        return mesh
    numbers = mesh.materials_of_triangles()
    numbers = np.where(numbers < 0, len(mesh.materials), numbers).astype(np.int32)
    materials = (*mesh.materials, MeshMaterial(image=mesh.texture))
    return replace(mesh, texture=None, materials=materials, triangle_materials=numbers)


def _without_false_parts(mesh: Mesh) -> Mesh:
    """Return the mesh with other names for groups that are called like a rigid part but are joined to the rest.

    In files of others "tongue" may be the skin of the mouth, and "eye_l" the eye with its lids.
    """
    vertices = weld_indices(mesh.vertices)[mesh.triangles]
    names = {}
    for name in RIGID_GROUPS:
        if name in mesh.groups:
            is_member = np.zeros(len(mesh.triangles), np.bool_)
            is_member[mesh.groups[name]] = True
            if np.isin(vertices[is_member], vertices[~is_member]).any():
                names[name] = f"{name}_of_file"
    return replace(mesh, groups={names.get(name, name): members for name, members in mesh.groups.items()})


def find_file_to_model(points: NDArray[np.float64], /) -> SimilarityTransform:
    """Return the similarity that brings control points (n, 3) of any unit and rotation to model centimetres.

    6.4 cm between the pupils, the midpoint of the pupils where the default head has it. A face that lies on its back
    or is upside down is rotated upright; one within MAX_TILT of upright is not rotated.
    Raises ValueError if the points are not those of a face.
    """
    try:
        eye_distance = Fapu.measure(points).es0
    except ValueError as error:
        raise ValueError("pupils, nose, lids and lips must lie apart") from error
    rotation = fit_similarity(points, default_points()).rotation
    if np.trace(rotation) >= 1 + 2 * np.cos(MAX_TILT):
        rotation = np.eye(3)
    scale = ES0_CM / eye_distance
    return SimilarityTransform(rotation, scale, EYE_MIDPOINT - scale * rotation @ points[PUPILS].mean(axis=0))


def _find_hinge(points: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]] | None:
    """Return the jaw's hinge where the default head has it relative to the control points."""
    hinge = default_joints().hinge
    if hinge is None:
        return None
    to_default = fit_similarity(points, default_points())
    return to_default.inverse_apply(hinge[0]), hinge[1] @ to_default.rotation
