import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.face.head_pose import NEUTRAL_POSE, HeadPose

angles = st.floats(-1.2, 1.2)


@pytest.mark.slow
@given(st.lists(st.floats(-3, 3), min_size=6, max_size=6))
def test_a_pose_equals_that_of_its_vector(vector: list[float]) -> None:
    assert HeadPose.from_vector(np.array(vector)).to_vector() == pytest.approx(vector)


@pytest.mark.slow
@given(angles, angles, angles)
def test_the_matrix_is_a_rotation(x: float, y: float, z: float) -> None:
    matrix = HeadPose(np.array([x, y, z]), np.zeros(2), 0.0).matrix()
    assert matrix @ matrix.T == pytest.approx(np.eye(3), abs=1e-12)
    assert np.linalg.det(matrix) == pytest.approx(1)


@pytest.mark.parametrize(
    ("axis", "which", "sign"),
    [((0, 1, 0), 0, 1), ((1, 0, 0), 1, -1), ((0, 0, 1), 2, 1)],
    ids=["yaw to the subject's left", "pitch up", "roll"],
)
def test_angles_about_one_axis_have_their_signs(axis: tuple[int, int, int], which: int, sign: int) -> None:
    pose = HeadPose(np.radians(20.0) * np.array(axis), np.zeros(2), 0.0)
    expected = [0.0, 0.0, 0.0]
    expected[which] = 20.0 * sign
    assert pose.yaw_pitch_roll() == pytest.approx(expected, abs=1e-9)


def test_positive_yaw_moves_the_nose_to_the_frames_right() -> None:
    pose = HeadPose(np.array([0, 0.5, 0]), np.zeros(2), 0.0)
    assert (pose.matrix() @ [0, 0, 1])[0] > 0
    assert pose.yaw_pitch_roll()[0] > 0


def test_the_neutral_pose_looks_straight_ahead() -> None:
    assert NEUTRAL_POSE.yaw_pitch_roll() == pytest.approx((0, 0, 0))
    assert np.exp(NEUTRAL_POSE.log_scale) * 6.4 == pytest.approx(0.25)
