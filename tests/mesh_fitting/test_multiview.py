"""Triangulation inverts the projection."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.mesh_fitting.multiview import LandmarkView, camera_pose, triangulate
from conf.render.camera import ViewState, clip_matrix

POINTS = np.random.default_rng(4).uniform(-6, 6, (30, 3))


def view(yaw: float, pitch: float) -> LandmarkView:
    clip = clip_matrix(camera_pose((yaw, pitch), height=24.0), ViewState(), aspect=1.0)
    projected = POINTS @ clip[:, :3].T + clip[:, 3]
    return LandmarkView(projected[:, :2] / projected[:, 3:], clip)


@pytest.mark.slow
@given(first=st.floats(-30, -5), second=st.floats(5, 30), pitch=st.floats(-20, 20))
def test_two_views_give_the_points_back(first: float, second: float, pitch: float) -> None:
    np.testing.assert_allclose(triangulate([view(first, 0.0), view(second, pitch)]), POINTS, atol=1e-6)


def test_yaw_rotates_the_face_to_the_images_right_and_pitch_up() -> None:
    nose = np.array([0.0, 0.0, 1.0])
    assert (camera_pose((20.0, 0.0), height=24.0).matrix() @ nose)[0] > 0.3
    assert (camera_pose((0.0, 20.0), height=24.0).matrix() @ nose)[1] > 0.3


@pytest.mark.parametrize("height", [3.0, 24.0])
def test_the_centre_is_in_the_middle_of_the_image(height: float) -> None:
    clip = clip_matrix(camera_pose((0.0, 0.0), height=height, centre=(1.0, 2.0)), ViewState(), aspect=1.0)
    projected = clip @ [1.0, 2.0, 4.0, 1.0]  # in the face's plane, where perspective keeps the scale
    np.testing.assert_allclose(projected[:2] / projected[3], 0.0, atol=1e-9)
