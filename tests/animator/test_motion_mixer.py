import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.animator.motion_mixer import mix_motion, with_eye_contact
from conf.animator.motion_player import REST_POSE, MotionPlayer, MotionSample
from conf.animator.state.editor import ViewSettings
from conf.face.animation.action_units import load_action_units
from conf.face.animation.expression_state import ExpressionState
from conf.face.animation.gaze import gaze_angles, gaze_displacements
from conf.face.animation.idle_motion import IdleMotion
from conf.face.formats.dpc import MotionClip
from conf.render.camera import ViewState

IDLE = IdleMotion(np.random.default_rng(5))
angles = st.floats(-0.4, 0.4)


def test_without_idle_motion_the_face_is_at_rest() -> None:
    sample = mix_motion(None, ExpressionState(idle=False), IDLE, ViewSettings(), 2.0)
    assert np.abs(sample.displacements).max() == 0 and sample.pose is REST_POSE


def test_idle_motion_moves_head_and_eyelids() -> None:
    samples = [mix_motion(None, ExpressionState(), IDLE, ViewSettings(), now) for now in np.arange(0.0, 8.0, 0.1)]
    assert max(np.abs(sample.displacements).max() for sample in samples) > 500, "a blink"
    assert max(np.abs(sample.pose.rotation).max() for sample in samples) > 0.005


def test_action_units_are_added_to_a_recording_and_idle_motion_is_not() -> None:
    values = np.full((3, 50, 3), 7.0, np.float32)
    player = MotionPlayer("a", MotionClip(10.0, "fapu", values))
    sample = mix_motion(player, ExpressionState().set_unit(12, 1.0), IDLE, ViewSettings(), 0.0)
    np.testing.assert_allclose(sample.displacements[0], 7.0 + load_action_units()[12][0], atol=1e-3)
    assert sample.pose is REST_POSE


@pytest.mark.slow
@given(angles, angles)
def test_with_eye_contact_the_eyes_look_at_the_viewer(yaw: float, pitch: float) -> None:
    sample = MotionSample(gaze_displacements(0.2, -0.1), REST_POSE)
    left, right = gaze_angles(with_eye_contact(sample, ViewState(yaw=yaw, pitch=pitch)).displacements)
    np.testing.assert_allclose(left, right, atol=1e-6)
    assert left[0] == pytest.approx(-yaw, abs=0.06)
    assert np.sign(left[1]) == -np.sign(pitch) or abs(pitch) < 0.05


def test_the_eyes_look_ahead_if_the_viewer_is_behind_the_head() -> None:
    still = MotionSample(np.zeros((50, 3), np.float32), REST_POSE)
    eyes = gaze_angles(with_eye_contact(still, ViewState(yaw=2.0)).displacements)
    np.testing.assert_allclose(eyes, 0.0, atol=1e-6)
