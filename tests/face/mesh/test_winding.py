import numpy as np
import pytest
import trimesh

from conf.face.formats.obj import RawMesh
from conf.face.mesh.mesh import build_mesh
from conf.face.mesh.winding import is_inside_out, orient_outwards, triangle_normals

BALL = trimesh.creation.icosphere(subdivisions=2, radius=2.0)
VERTICES, TRIANGLES = np.asarray(BALL.vertices), np.asarray(BALL.faces)


def test_triangle_normals_are_twice_the_area() -> None:
    normals = triangle_normals(VERTICES, TRIANGLES)
    assert np.linalg.norm(normals, axis=1) == pytest.approx(2 * BALL.area_faces)
    np.testing.assert_allclose(normals / np.linalg.norm(normals, axis=1)[:, None], BALL.face_normals, atol=1e-9)


def test_inside_out_is_detected_wherever_the_mesh_lies() -> None:
    assert not is_inside_out(VERTICES + 100, TRIANGLES)
    assert is_inside_out(VERTICES + 100, TRIANGLES[:, ::-1])


def test_orient_outwards_reverses_an_inverted_mesh_only() -> None:
    corners = np.stack([TRIANGLES, np.full_like(TRIANGLES, -1)], axis=-1)
    mesh = build_mesh(RawMesh(VERTICES, np.empty((0, 2)), corners, {}, None))
    inverted = build_mesh(RawMesh(VERTICES, np.empty((0, 2)), corners[:, ::-1], {}, None))
    assert orient_outwards(mesh) is mesh
    np.testing.assert_array_equal(orient_outwards(inverted).triangles, mesh.triangles)
    np.testing.assert_array_equal(orient_outwards(inverted).render_triangles, inverted.render_triangles[:, ::-1])


def test_a_closed_part_that_is_inside_out_is_turned() -> None:
    small = 0.2 * VERTICES + [0.0, 0.0, 5.0]
    triangles = np.concatenate([TRIANGLES, TRIANGLES[:, ::-1] + len(VERTICES)])
    corners = np.stack([triangles, np.full_like(triangles, -1)], axis=-1)
    mesh = build_mesh(RawMesh(np.concatenate([VERTICES, small]), np.empty((0, 2)), corners, {}, None))
    turned = orient_outwards(mesh).triangles
    np.testing.assert_array_equal(turned[: len(TRIANGLES)], TRIANGLES)
    np.testing.assert_array_equal(turned[len(TRIANGLES) :], triangles[len(TRIANGLES) :, ::-1])
