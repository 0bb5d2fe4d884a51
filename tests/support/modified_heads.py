"""The default head with parts removed, without groups and texture: a stranger's mesh whose control points are known."""

from dataclasses import replace

import numpy as np

from conf.face.default_head import DEFAULT_HEAD, default_points
from conf.face.deformation.face_model import FaceModel
from conf.face.fitting.custom_face import prepare_face
from conf.face.loading import build_face
from conf.face.mesh.editing import submesh
from conf.face.mesh.mesh import Mesh, load_mesh

MOUTH = ("mouth", "teeth_upper", "teeth_lower", "tongue")
EYEBALLS = ("eye_l", "eye_r")
OUTSIDE = ("shirt", "lashes", "hair")


def head_without(*groups: str) -> Mesh:
    """Return the head, bald and without some groups."""
    head = load_mesh(DEFAULT_HEAD)
    kept = np.ones(len(head.triangles), dtype=np.bool_)
    for name in (*groups, *OUTSIDE):
        kept[head.groups[name]] = False
    mesh = submesh(head, kept)
    return replace(mesh, groups={"default": np.arange(len(mesh.triangles))}, texture=None)


def face_without(*groups: str) -> FaceModel:
    """Return the face that is made of the head without some groups."""
    prepared = prepare_face(head_without(*groups), default_points())
    return build_face(prepared.mesh, prepared.points, rig=prepared.rig)
