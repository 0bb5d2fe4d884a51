"""Lines of sight meet again where they came from."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.mesh_fitting.multiview import LandmarkView, camera_pose, triangulate
from conf.render.camera import ViewState, clip_matrix

POINTS = np.random.default_rng(4).uniform(-6, 6, (30, 3))


def sight(yaw: float, pitch: float) -> LandmarkView:
    clip = clip_matrix(camera_pose((yaw, pitch), height=24.0), ViewState(), aspect=1.0)
    seen = POINTS @ clip[:, :3].T + clip[:, 3]
    return LandmarkView(seen[:, :2] / seen[:, 3:], clip)


@given(first=st.floats(-30, -5), second=st.floats(5, 30), pitch=st.floats(-20, 20))
def test_two_sides_give_the_points_back(first: float, second: float, pitch: float) -> None:
    np.testing.assert_allclose(triangulate([sight(first, 0.0), sight(second, pitch)]), POINTS, atol=1e-6)


def test_yaw_turns_the_face_to_the_pictures_right_and_pitch_lifts_it() -> None:
    nose = np.array([0.0, 0.0, 1.0])
    assert (camera_pose((20.0, 0.0), height=24.0).matrix() @ nose)[0] > 0.3
    assert (camera_pose((0.0, 20.0), height=24.0).matrix() @ nose)[1] > 0.3


@pytest.mark.parametrize("height", [3.0, 24.0])
def test_the_centre_is_drawn_in_the_middle(height: float) -> None:
    clip = clip_matrix(camera_pose((0.0, 0.0), height=height, centre=(1.0, 2.0)), ViewState(), aspect=1.0)
    seen = clip @ [1.0, 2.0, 4.0, 1.0]  # in the face's plane, where the lens keeps the scale
    np.testing.assert_allclose(seen[:2] / seen[3], 0.0, atol=1e-9)
