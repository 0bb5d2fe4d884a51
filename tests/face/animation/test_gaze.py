import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.face.animation.gaze import EYE_RADIUS, gaze_angles, gaze_displacements
from conf.face.control_points import CONTROL_POINT_INDEX, PUPILS

angles = st.floats(-1.2, 1.2)


@pytest.mark.slow
@given(yaw=angles, pitch=angles)
def test_gaze_angles_inverts_gaze_displacements(yaw: float, pitch: float) -> None:
    np.testing.assert_allclose(gaze_angles(gaze_displacements(yaw, pitch)), [[yaw, pitch]] * 2, atol=1e-5)


def test_left_is_positive_x_and_up_is_positive_y() -> None:
    displacements = gaze_displacements(0.2, 0.1)
    assert (displacements[PUPILS, :2] > 0).all()
    assert displacements[CONTROL_POINT_INDEX["eyelid_upper_l"], 1] == pytest.approx(100.0)
    assert np.count_nonzero(gaze_displacements(0.0, 0.0)) == 0


def test_an_excessive_displacement_is_90_degrees() -> None:
    displacements = gaze_displacements(0.0, 0.0)
    displacements[PUPILS, 0] = 5 * EYE_RADIUS
    np.testing.assert_allclose(gaze_angles(displacements)[:, 0], np.pi / 2)
