"""The default head's teeth, put into the head they come from, lie where they were; elsewhere the lips hide them."""

import numpy as np
import pytest

from conf.face.control_points import control_point_indices
from conf.face.default_head import DEFAULT_HEAD, default_points
from conf.face.fitting.teeth_insertion import GROUPS, insert_teeth
from conf.face.mesh.mesh import load_mesh
from conf.face.mesh.raycast import cast_front_rays
from conf.face.mesh.winding import triangle_normals
from tests.support.modified_heads import MOUTH, head_without
from tests.support.sheet_face import SheetFace


@pytest.mark.slow
def test_the_teeth_lie_where_the_originals_were() -> None:
    head, mesh = load_mesh(DEFAULT_HEAD), head_without(*MOUTH)
    for outwards in (True, False):
        filled = insert_teeth(mesh, default_points(), outwards=outwards)
        for name in GROUPS:
            own, original = filled.triangles[filled.groups[name]], head.triangles[head.groups[name]]
            moved = filled.vertices[own].mean(axis=(0, 1)) - head.vertices[original].mean(axis=(0, 1))
            assert np.abs(moved[:2]).max() < 0.01 and -0.7 < moved[2] <= 0.01  # at most moved back
            sign = 1 if outwards else -1
            normals = triangle_normals(filled.vertices, own), triangle_normals(head.vertices, original)
            assert (np.einsum("fi,fi->f", *normals) * sign >= 0).mean() > 0.99
        assert filled.render_vertices[filled.render_triangles].tolist() == filled.triangles.tolist()


@pytest.mark.slow
def test_the_teeth_fit_a_narrow_mouth_and_are_hidden(shut_face: SheetFace) -> None:
    points = shut_face.points.copy()
    points[control_point_indices("inner_lip_corner"), 0] *= 0.9
    filled = insert_teeth(shut_face.mesh, points, outwards=True)
    teeth = filled.vertices[len(shut_face.mesh.vertices) :]
    depth = cast_front_rays(teeth[:, :2], shut_face.mesh.vertices, shut_face.mesh.triangles).points[:, 2]
    assert (depth > teeth[:, 2]).mean() > 0.95
