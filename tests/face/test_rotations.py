import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from scipy.spatial.transform import Rotation

from conf.face.rotations import rotation_matrix, rotation_vector, yaw_pitch_roll

units = st.floats(-1, 1).map(lambda x: 0.0 if abs(x) < 1e-9 else x)
axes = hnp.arrays(np.float64, 3, elements=units).filter(lambda axis: np.linalg.norm(axis) > 1e-3)
angles = st.floats(0, math.pi - 1e-6) | st.sampled_from([0.0, 1e-12, 1e-9, 1e-7, 2e-6, 1e-4])


def turn(axis: np.ndarray, angle: float) -> np.ndarray:
    return np.asarray(axis / np.linalg.norm(axis) * angle)


@pytest.mark.slow
@given(axes, angles)
def test_vectors_and_matrices_equal_scipys(axis: np.ndarray, angle: float) -> None:
    vector = turn(axis, angle)
    matrix = Rotation.from_rotvec(vector).as_matrix()
    assert rotation_matrix(vector) == pytest.approx(matrix, abs=1e-14)
    assert rotation_vector(matrix) == pytest.approx(vector, abs=1e-9)


@pytest.mark.slow
@given(st.floats(-3.1, 3.1), st.floats(-1.5, 1.5), st.floats(-3.1, 3.1))
def test_angles_are_those_that_a_matrix_was_made_of(yaw: float, pitch: float, roll: float) -> None:
    matrix = Rotation.from_euler("YXZ", [yaw, pitch, roll]).as_matrix()
    assert yaw_pitch_roll(matrix) == pytest.approx((yaw, pitch, roll), abs=1e-12)


@pytest.mark.parametrize("axis", np.eye(3))
def test_half_a_turn_has_a_vector(axis: np.ndarray) -> None:
    assert rotation_vector(2 * np.outer(axis, axis) - np.eye(3)) == pytest.approx(math.pi * axis)


@pytest.mark.parametrize("pitch", [math.pi / 2, -math.pi / 2])
@pytest.mark.parametrize("yaw", [0.3, -2.0])
def test_straight_up_and_down_there_is_no_roll(yaw: float, pitch: float) -> None:
    matrix = Rotation.from_euler("YXZ", [yaw, pitch, 0.0]).as_matrix()
    assert yaw_pitch_roll(matrix) == pytest.approx((yaw, pitch, 0.0), abs=1e-7)
