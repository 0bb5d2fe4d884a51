"""The default head's teeth, put into the head they come from, lie where they were; elsewhere the lips hide them."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh

from conf.face.control_points import control_point_indices
from conf.face.default_head import DEFAULT_HEAD, default_points
from conf.face.fitting.teeth_insertion import GROUPS, TEETH, complete_teeth, insert_teeth
from conf.face.formats.mtl import MeshMaterial
from conf.face.mesh.editing import submesh
from conf.face.mesh.mesh import Mesh, load_mesh
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


def with_bands(mesh: Mesh) -> Mesh:
    """Return the mesh with two arches of 96 triangles, as base figures have them for teeth that are fitted later."""
    for name, height in (("teeth_upper", -3.8), ("teeth_lower", -4.9)):
        band = trimesh.creation.annulus(1.8, 2.1, 0.8, sections=12)
        vertices = np.asarray(band.vertices)[:, [0, 2, 1]] + [0.0, height, 2.6]
        first, faces = len(mesh.vertices), np.asarray(band.faces, np.int32)
        numbers = np.arange(len(mesh.triangles), len(mesh.triangles) + len(faces))
        mesh = replace(
            mesh,
            vertices=np.concatenate([mesh.vertices, vertices]),
            triangles=np.concatenate([mesh.triangles, faces + np.int32(first)]),
            uvs=np.concatenate([mesh.uvs, np.zeros((len(vertices), 2))]),
            render_vertices=np.concatenate([mesh.render_vertices, np.arange(first, first + len(vertices), dtype="i4")]),
            render_triangles=np.concatenate([mesh.render_triangles, faces + np.int32(len(mesh.render_vertices))]),
            groups=mesh.groups | {name: numbers},
        )
    return mesh


@pytest.mark.slow
def test_bands_in_place_of_teeth_are_replaced_and_a_tongue_is_put_in() -> None:
    mesh = with_bands(head_without(*MOUTH))
    filled, remark = complete_teeth(mesh, default_points(), outwards=True)
    assert remark == "teeth without a shape: replaced"
    head = load_mesh(DEFAULT_HEAD)
    for name in GROUPS:
        assert len(filled.groups[name]) == len(head.groups[name])
    drawn = set(filled.triangles.ravel().tolist())
    assert not drawn & set(mesh.group_vertices(*TEETH).tolist())


@pytest.mark.slow
def test_bands_with_a_picture_of_teeth_are_kept() -> None:
    mesh = with_bands(head_without(*MOUTH))
    painted = replace(
        mesh,
        materials=(MeshMaterial(image=DEFAULT_HEAD.with_name("skin.webp")),),
        triangle_materials=np.zeros(len(mesh.triangles), np.int32),
    )
    filled, remark = complete_teeth(painted, default_points(), outwards=True)
    assert remark == "no tongue: put in"
    for name in TEETH:
        assert filled.groups[name].tolist() == mesh.groups[name].tolist()


@pytest.mark.slow
def test_a_missing_tongue_is_put_between_the_faces_own_teeth() -> None:
    head = load_mesh(DEFAULT_HEAD)
    assert complete_teeth(head, default_points(), outwards=True) == (head, None)
    kept = np.ones(len(head.triangles), np.bool_)
    kept[head.groups["tongue"]] = False
    bare = submesh(head, kept)
    filled, remark = complete_teeth(bare, default_points(), outwards=True)
    assert remark == "no tongue: put in"
    tongue, original = (m.vertices[m.group_vertices("tongue")] for m in (filled, head))
    np.testing.assert_allclose(tongue, original, atol=1e-9)
