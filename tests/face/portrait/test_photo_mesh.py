from dataclasses import replace

import numpy as np
import pytest

from conf.face.head_pose import HeadPose
from conf.face.portrait import contours
from conf.face.portrait.photo_mesh import (
    MAX_BORDER_EXTENSION,
    border_extension,
    build_mesh,
    extend_outline,
    signed_areas,
    triangles_on_person,
)
from conf.face.portrait.photographed_face import project
from tests.support.synthetic_portrait import POSE, face_shape


def test_triangles_are_counter_clockwise_and_outlines_are_vertices() -> None:
    mesh = build_mesh(face_shape())
    assert signed_areas(mesh.positions, mesh.triangles).min() > 0
    assert len(mesh.positions) > len(contours.PORTRAIT_LANDMARKS)
    assert set(range(len(contours.PORTRAIT_LANDMARKS))) <= set(mesh.triangles.ravel().tolist())


def test_no_triangle_crosses_the_lips() -> None:
    mesh = build_mesh(face_shape())
    upper = set(contours.landmark_rows(contours.UPPER_INNER_LIP[1:-1]))
    lower = set(contours.landmark_rows(contours.LOWER_INNER_LIP[1:-1]))
    between = mesh.positions[contours.landmark_rows(contours.UPPER_INNER_LIP + contours.LOWER_INNER_LIP)]
    for triangle in mesh.triangles.tolist():
        if upper & set(triangle) and lower & set(triangle):
            centre = mesh.positions[triangle].mean(axis=0)
            assert (between.min(axis=0) <= centre).all() and (centre <= between.max(axis=0)).all(), triangle


def test_the_background_has_no_triangles() -> None:
    mesh = build_mesh(face_shape())
    used = mesh.positions[np.unique(mesh.triangles)]
    assert np.abs(used[:, 0]).max() < 0.62


@pytest.mark.slow
def test_no_triangle_has_corners_on_both_lips_and_elsewhere() -> None:
    for tilt in np.linspace(-0.4, 0.4, 9):
        pose = HeadPose(np.array([0.0, 0.0, tilt]), POSE.position, POSE.log_scale)
        triangles = build_mesh(face_shape(pose)).triangles
        upper, lower = map(contours.landmark_rows, (contours.UPPER_INNER_LIP, contours.LOWER_INNER_LIP))
        across = np.isin(triangles, upper[1:-1]).any(axis=1) & np.isin(triangles, lower[1:-1]).any(axis=1)
        assert np.isin(triangles[across], upper + lower).all()


SQUARE = np.array([(-0.2, -0.2), (0.2, -0.2), (0.2, 0.2), (-0.2, 0.2)])


def test_triangles_near_the_person_are_kept() -> None:
    positions = np.array(
        [(0.0, 0.0), (0.1, 0.0), (0.0, 0.1), (0.5, 0.5), (0.6, 0.5), (0.5, 0.6), (0.21, 0.0), (0.3, 0.1)]
    )
    triangles = np.array([(0, 1, 2), (3, 4, 5), (6, 7, 3), (0, 6, 7)], dtype=np.int32)
    np.testing.assert_array_equal(triangles_on_person(positions, triangles, SQUARE, 0.01), [True, False, True, True])
    assert triangles_on_person(positions, triangles, SQUARE[:2], 0.01).all()


def test_outline_points_at_the_border_are_moved_beyond_it() -> None:
    face = replace(face_shape(), outline=np.array([(-0.3, -0.5), (0.66, 0.0), (0.1, 0.3)]))
    extension = border_extension(face)
    expected = [(-0.3, -0.5 - extension), (2 / 3 + extension, 0.0), (0.1, 0.3)]
    np.testing.assert_allclose(extend_outline(face), expected)


def test_the_extension_holds_half_a_face_and_is_limited() -> None:
    face = face_shape()
    oval = project(face.points, face.pose)[contours.OVAL_ROWS]
    assert border_extension(face) > 0.5 * np.ptp(oval[:, 0])
    assert border_extension(face_shape(HeadPose(POSE.rotation, POSE.position, 0.0))) == MAX_BORDER_EXTENSION
