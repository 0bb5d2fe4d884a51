"""Faces: control points, meshes, the operator that deforms them, and files of motion. No I/O devices, no clock.

    face = load_face()                          # the default head, or a mesh with its PPC file
    vertices = face.deform(displacements)       # (50, 3) FAPU units -> (V, 3) cm

The names below are the public ones; they are imported when they are first used.
"""

from typing import TYPE_CHECKING

from conf.lazy import lazy_attributes

_SOURCES = {
    "CONTROL_POINTS": "control_points",
    "DEFAULT_HEAD": "default_head",
    "DeformerOptions": "deformation.face_model",
    "FaceModel": "deformation.face_model",
    "Fapu": "fapu",
    "HeadPose": "head_pose",
    "KERNELS": "deformation.rbf",
    "Mesh": "mesh.mesh",
    "MotionClip": "formats.dpc",
    "SurfaceGraph": "mesh.surface_graph",
    "build_face": "loading",
    "build_operator": "deformation.rbf",
    "choose_anchors": "deformation.operator_builder",
    "combine_action_units": "animation.action_units",
    "load_face": "loading",
    "load_mesh": "mesh.mesh",
    "read_dpc": "formats.dpc",
    "read_ppc": "formats.ppc",
    "split_regions": "deformation.regions",
    "write_dpc": "formats.dpc",
}

if TYPE_CHECKING:
    from conf.face.animation.action_units import combine_action_units as combine_action_units
    from conf.face.control_points import CONTROL_POINTS as CONTROL_POINTS
    from conf.face.default_head import DEFAULT_HEAD as DEFAULT_HEAD
    from conf.face.deformation.face_model import DeformerOptions as DeformerOptions
    from conf.face.deformation.face_model import FaceModel as FaceModel
    from conf.face.deformation.operator_builder import choose_anchors as choose_anchors
    from conf.face.deformation.rbf import KERNELS as KERNELS
    from conf.face.deformation.rbf import build_operator as build_operator
    from conf.face.deformation.regions import split_regions as split_regions
    from conf.face.fapu import Fapu as Fapu
    from conf.face.formats.dpc import MotionClip as MotionClip
    from conf.face.formats.dpc import read_dpc as read_dpc
    from conf.face.formats.dpc import write_dpc as write_dpc
    from conf.face.formats.ppc import read_ppc as read_ppc
    from conf.face.head_pose import HeadPose as HeadPose
    from conf.face.loading import build_face as build_face
    from conf.face.loading import load_face as load_face
    from conf.face.mesh.mesh import Mesh as Mesh
    from conf.face.mesh.mesh import load_mesh as load_mesh
    from conf.face.mesh.surface_graph import SurfaceGraph as SurfaceGraph
else:
    __getattr__ = lazy_attributes(__name__, _SOURCES)

__all__ = list(_SOURCES)
