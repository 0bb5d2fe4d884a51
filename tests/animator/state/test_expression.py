import numpy as np
import pytest

from conf.animator.state.expression import ExpressionState
from conf.face.animation.action_units import load_action_units, load_emotions
from conf.face.animation.timed_expression import Envelope

JOY = load_emotions()["joy"]
SOON = Envelope(onset=0.2, hold=0.5, release=0.3)


def test_an_emotion_comes_stays_and_goes() -> None:
    expressing = ExpressionState(SOON).play("joy", JOY, 10.0)
    assert np.abs(expressing.at(10.0)).max() == 0
    np.testing.assert_allclose(expressing.at(10.5), JOY, atol=1e-3)
    assert expressing.active(10.5) == "joy"
    assert np.abs(expressing.at(11.5)).max() == 0
    assert expressing.without_finished(10.5).played and not expressing.without_finished(11.5).played


def test_one_that_stays_goes_when_released() -> None:
    expressing = ExpressionState(SOON, hold_until_released=True).play("joy", JOY, 0.0)
    np.testing.assert_allclose(expressing.at(900.0), JOY, atol=1e-3)
    released = expressing.release(900.0)
    assert released.active(900.0) is None
    assert 0 < np.abs(released.at(900.2)).max() < np.abs(JOY).max()
    assert not released.without_finished(901.0).played


def test_the_next_emotion_takes_over() -> None:
    expressing = ExpressionState(SOON, hold_until_released=True).play("joy", JOY, 0.0)
    both = expressing.play("anger", load_emotions()["anger"], 5.0)
    assert both.active(5.0) == "anger" and [p.name for p in both.played] == ["joy", "anger"]
    np.testing.assert_allclose(both.at(7.0), load_emotions()["anger"], atol=1e-3)


def test_action_units_lie_over_it_and_zero_takes_them_away() -> None:
    expressing = ExpressionState().set_unit(12, 0.5)
    np.testing.assert_allclose(expressing.at(0.0), 0.5 * load_action_units()[12], atol=1e-3)
    assert expressing.set_unit(12, 0.0).units == {}


def test_intensity_is_the_envelopes() -> None:
    expressing = ExpressionState(Envelope(0.1, 1.0, 0.1, intensity=0.5)).play("joy", JOY, 0.0)
    assert np.abs(expressing.at(0.6)).max() == pytest.approx(np.abs(JOY).max() / 2, rel=1e-3)
