import numpy as np
import pytest

from conf.face.animation.action_units import load_action_units, load_emotions
from conf.face.animation.expression_state import ExpressionState
from conf.face.animation.timed_expression import Envelope

JOY, ANGER = load_emotions()["joy"], load_emotions()["anger"]
SHORT = Envelope(onset=0.2, hold=0.5, release=0.3)


def test_an_expression_follows_its_envelope_and_is_removed() -> None:
    state = ExpressionState(SHORT).play("joy", JOY, 10.0)
    assert np.abs(state.at(10.0)).max() == 0
    np.testing.assert_allclose(state.at(10.5), JOY, atol=1e-3)
    assert state.active(10.5) == "joy"
    assert np.abs(state.at(11.5)).max() == 0
    assert state.without_finished(10.5).running and not state.without_finished(11.5).running


def test_a_held_expression_ends_after_its_release() -> None:
    state = ExpressionState(SHORT, hold_until_released=True).play("joy", JOY, 0.0)
    np.testing.assert_allclose(state.at(900.0), JOY, atol=1e-3)
    released = state.release(900.0)
    assert released.active(900.0) is None
    assert 0 < np.abs(released.at(900.2)).max() < np.abs(JOY).max()
    assert not released.without_finished(901.0).running


def test_a_new_expression_releases_the_running_one() -> None:
    state = ExpressionState(SHORT, hold_until_released=True).play("joy", JOY, 0.0).play("anger", ANGER, 5.0)
    assert state.active(5.0) == "anger" and [e.name for e in state.running] == ["joy", "anger"]
    np.testing.assert_allclose(state.at(7.0), ANGER, atol=1e-3)


def test_action_units_are_added_and_zero_removes_them() -> None:
    state = ExpressionState().set_unit(12, 0.5)
    np.testing.assert_allclose(state.at(0.0), 0.5 * load_action_units()[12], atol=1e-3)
    assert state.set_unit(12, 0.0).units == {}


def test_the_intensity_is_that_of_the_envelope() -> None:
    state = ExpressionState(Envelope(0.1, 1.0, 0.1, intensity=0.5)).play("joy", JOY, 0.0)
    assert np.abs(state.at(0.6)).max() == pytest.approx(np.abs(JOY).max() / 2, rel=1e-3)
