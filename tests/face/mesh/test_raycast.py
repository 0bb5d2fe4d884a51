"""Rays against the equations they solve, nearest points against trimesh's own."""

import numpy as np
import pytest
import trimesh
from numpy.typing import NDArray

from conf.face.mesh.raycast import cast_clip_rays, cast_front_rays, nearest_normals, nearest_points

BALL = trimesh.creation.icosphere(subdivisions=3, radius=2.0)
VERTICES, TRIANGLES = np.asarray(BALL.vertices), np.asarray(BALL.faces, dtype=np.int32)
LENS = np.array([[0.3, 0, 0, 0], [0, 0.3, 0, 0], [0, 0, -0.05, 0.1], [0, 0, -0.1, 1.0]])  # a camera on +z


@pytest.fixture
def places() -> NDArray[np.float64]:
    return np.random.default_rng(3).uniform(-2.2, 2.2, (80, 2))


def test_front_hits_solve_the_equations_of_ray_and_triangle(places: NDArray[np.float64]) -> None:
    hits = cast_front_rays(places, VERTICES, TRIANGLES)
    a, b, c = (VERTICES[TRIANGLES[:, corner]] for corner in range(3))
    systems = np.stack([b - a, c - a, np.tile([0.0, 0.0, 1.0], (len(a), 1))], axis=2)  # a + u ab + v ac = place - t z
    upright = np.abs(np.linalg.det(systems)) > 1e-12  # the others are seen edge on
    for place, point, triangle in zip(places, hits.points, hits.triangles, strict=True):
        u, v, t = np.linalg.solve(systems[upright], ([*place, 0.0] - a[upright])[..., None])[..., 0].T
        met = (u >= 0) & (v >= 0) & (u + v <= 1)
        assert (triangle >= 0) == met.any()
        if met.any():
            np.testing.assert_allclose(point, [*place, -t[met].min()], atol=1e-9)
            assert met[np.flatnonzero(upright) == triangle].all()


def test_a_hit_lies_where_the_camera_sees_it(places: NDArray[np.float64]) -> None:
    places = places / 4
    hits = cast_clip_rays(places, LENS, VERTICES, TRIANGLES)
    seen = np.isfinite(hits[:, 0])
    assert seen.sum() > 20
    clip = hits[seen] @ LENS[:, :3].T + LENS[:, 3]
    np.testing.assert_allclose(clip[:, :2] / clip[:, 3:], places[seen], atol=1e-9)
    assert (hits[seen, 2] > -0.1).all()  # the near side of the ball


def test_nothing_is_hit_beside_the_mesh_and_by_no_ray() -> None:
    assert np.isnan(cast_front_rays(np.array([[5.0, 5.0]]), VERTICES, TRIANGLES).points).all()
    assert cast_front_rays(np.empty((0, 2)), VERTICES, TRIANGLES).points.shape == (0, 3)
    assert cast_clip_rays(np.empty((0, 2)), LENS, VERTICES, TRIANGLES).shape == (0, 3)


def test_the_nearest_point_is_the_nearest_of_all() -> None:
    rng = np.random.default_rng(5)
    places = rng.normal(size=(20, 3))
    places *= rng.uniform(1.7, 2.3, (20, 1)) / np.linalg.norm(places, axis=1, keepdims=True)
    facing = places / np.linalg.norm(places, axis=1, keepdims=True)
    found = nearest_points(places, facing, VERTICES, TRIANGLES, reach=1.0)
    expected = trimesh.proximity.closest_point_naive(BALL, places)[0]
    np.testing.assert_allclose(found, expected, atol=1e-9)


def test_a_surface_that_faces_away_or_is_out_of_reach_is_not_taken() -> None:
    place = np.array([[0.0, 0.0, 2.1]])
    front = np.array([[0.0, 0.0, 1.0]])
    assert np.isfinite(nearest_points(place, front, VERTICES, TRIANGLES, reach=0.5)).all()
    assert np.isnan(nearest_points(place, -front, VERTICES, TRIANGLES, reach=0.5)).all()
    assert np.isnan(nearest_points(place + 3, front, VERTICES, TRIANGLES, reach=0.5)).all()


def test_a_ball_is_normal_to_its_radius() -> None:
    normals = nearest_normals(VERTICES[:5], VERTICES, TRIANGLES)
    np.testing.assert_allclose(normals, VERTICES[:5] / 2.0, atol=0.02)
