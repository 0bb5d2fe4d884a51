import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.animator.motion_player import REST_POSE
from conf.animator.state.view_settings import with_eye_contact
from conf.face.animation.gaze import gaze_angles, gaze_displacements
from conf.render.camera import ViewState

angles = st.floats(-0.4, 0.4)


@given(angles, angles)
def test_eyes_in_contact_look_back_along_the_line_of_sight(yaw: float, pitch: float) -> None:
    view = ViewState(yaw=yaw, pitch=pitch)
    straying = gaze_displacements(0.2, -0.1)
    left, right = gaze_angles(with_eye_contact(straying, REST_POSE, view))
    np.testing.assert_allclose(left, right, atol=1e-6)
    assert left[0] == pytest.approx(-yaw, abs=0.06)
    assert np.sign(left[1]) == -np.sign(pitch) or abs(pitch) < 0.05


def test_eyes_do_not_roll_after_a_viewer_behind_the_head() -> None:
    eyes = gaze_angles(with_eye_contact(np.zeros((50, 3), np.float32), REST_POSE, ViewState(yaw=2.0)))
    np.testing.assert_allclose(eyes, 0.0, atol=1e-6)
