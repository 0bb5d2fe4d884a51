"""Rays against the equations they solve, nearest points against trimesh's own."""

import numpy as np
import pytest
import trimesh
from numpy.typing import NDArray

from conf.face.mesh.raycast import cast_clip_rays, cast_front_rays, faces_viewer, nearest_points

BALL = trimesh.creation.icosphere(subdivisions=3, radius=2.0)
VERTICES, TRIANGLES = np.asarray(BALL.vertices), np.asarray(BALL.faces, dtype=np.int32)
LENS = np.array([[0.3, 0, 0, 0], [0, 0.3, 0, 0], [0, 0, -0.05, 0.1], [0, 0, -0.1, 1.0]])  # a camera on +z


@pytest.fixture
def positions() -> NDArray[np.float64]:
    return np.random.default_rng(3).uniform(-2.2, 2.2, (80, 2))


def test_front_hits_satisfy_the_ray_triangle_equations(positions: NDArray[np.float64]) -> None:
    hits = cast_front_rays(positions, VERTICES, TRIANGLES)
    a, b, c = (VERTICES[TRIANGLES[:, corner]] for corner in range(3))
    systems = np.stack([b - a, c - a, np.tile([0.0, 0.0, 1.0], (len(a), 1))], axis=2)  # a + u ab + v ac = p - t z
    upright = np.abs(np.linalg.det(systems)) > 1e-12  # the others are edge-on
    for position, point, triangle in zip(positions, hits.points, hits.triangles, strict=True):
        u, v, t = np.linalg.solve(systems[upright], ([*position, 0.0] - a[upright])[..., None])[..., 0].T
        inside = (u >= 0) & (v >= 0) & (u + v <= 1)
        assert (triangle >= 0) == inside.any()
        if inside.any():
            np.testing.assert_allclose(point, [*position, -t[inside].min()], atol=1e-9)
            assert inside[np.flatnonzero(upright) == triangle].all()


def test_a_clip_ray_hits_the_nearest_point_that_projects_to_its_position(positions: NDArray[np.float64]) -> None:
    positions = positions / 4
    hits = cast_clip_rays(positions, LENS, VERTICES, TRIANGLES)
    visible = np.isfinite(hits[:, 0])
    assert visible.sum() > 20
    clip = hits[visible] @ LENS[:, :3].T + LENS[:, 3]
    np.testing.assert_allclose(clip[:, :2] / clip[:, 3:], positions[visible], atol=1e-9)
    assert (hits[visible, 2] > -0.1).all()  # the near side of the ball


def test_rays_beside_the_mesh_and_no_rays_hit_nothing() -> None:
    assert np.isnan(cast_front_rays(np.array([[5.0, 5.0]]), VERTICES, TRIANGLES).points).all()
    assert cast_front_rays(np.empty((0, 2)), VERTICES, TRIANGLES).points.shape == (0, 3)
    assert cast_clip_rays(np.empty((0, 2)), LENS, VERTICES, TRIANGLES).shape == (0, 3)


def test_the_nearest_point_agrees_with_trimesh() -> None:
    rng = np.random.default_rng(5)
    positions = rng.normal(size=(20, 3))
    positions *= rng.uniform(1.7, 2.3, (20, 1)) / np.linalg.norm(positions, axis=1, keepdims=True)
    directions = positions / np.linalg.norm(positions, axis=1, keepdims=True)
    found = nearest_points(positions, directions, VERTICES, TRIANGLES, reach=1.0)
    expected = trimesh.proximity.closest_point_naive(BALL, positions)[0]
    np.testing.assert_allclose(found, expected, atol=1e-9)


def test_surfaces_that_face_away_or_are_out_of_reach_are_ignored() -> None:
    position = np.array([[0.0, 0.0, 2.1]])
    front = np.array([[0.0, 0.0, 1.0]])
    assert np.isfinite(nearest_points(position, front, VERTICES, TRIANGLES, reach=0.5)).all()
    assert np.isnan(nearest_points(position, -front, VERTICES, TRIANGLES, reach=0.5)).all()
    assert np.isnan(nearest_points(position + 3, front, VERTICES, TRIANGLES, reach=0.5)).all()


def test_faces_viewer_tells_the_winding_of_the_visible_side(positions: NDArray[np.float64]) -> None:
    assert faces_viewer(positions, VERTICES, TRIANGLES)
    assert not faces_viewer(positions, VERTICES, TRIANGLES[:, ::-1])


def test_a_ray_through_the_middle_of_a_triangle_hits_it_and_one_through_a_degenerate_triangle_does_not() -> None:
    vertices = np.array([[-0.3, -0.2, 1.0], [0.3, -0.2, 1.0], [0.0, 0.4, 1.0], [0.0, 0.0, 5.0]])
    middle = np.array([[0.0, 0.0]])
    for corners in ([0, 1, 2], [2, 1, 0]):
        assert cast_front_rays(middle, vertices, np.array([corners], np.int32)).triangles.tolist() == [0]
    assert cast_front_rays(middle, vertices, np.array([[3, 3, 3]], np.int32)).triangles.tolist() == [-1]
