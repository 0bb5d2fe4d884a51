import numpy as np

from conf.animator.motion_mixer import mix_motion
from conf.animator.motion_player import REST_POSE, MotionPlayer, NamedClip
from conf.animator.state.expression import ExpressionState
from conf.animator.state.view_settings import ViewSettings
from conf.face.animation.action_units import load_action_units
from conf.face.animation.idle_motion import IdleMotion
from conf.face.formats.dpc import MotionClip

IDLE = IdleMotion(np.random.default_rng(5))


def test_a_still_face_without_idle_life_is_quite_still() -> None:
    now = mix_motion(None, ExpressionState(idle=False), IDLE, ViewSettings(), 2.0)
    assert np.abs(now.displacements).max() == 0 and now.pose is REST_POSE


def test_idle_life_moves_head_and_eyes() -> None:
    moments = [mix_motion(None, ExpressionState(), IDLE, ViewSettings(), now) for now in np.arange(0.0, 8.0, 0.1)]
    assert max(np.abs(now.displacements).max() for now in moments) > 500, "it blinks"
    assert max(np.abs(now.pose.rotation).max() for now in moments) > 0.005


def test_units_lie_over_a_recording_which_has_a_life_of_its_own() -> None:
    values = np.full((3, 50, 3), 7.0, np.float32)
    player = MotionPlayer(NamedClip("a", MotionClip(10.0, "fapu", values)))
    expressing = ExpressionState().set_unit(12, 1.0)
    now = mix_motion(player, expressing, IDLE, ViewSettings(), 0.0)
    np.testing.assert_allclose(now.displacements[0], 7.0 + load_action_units()[12][0], atol=1e-3)
