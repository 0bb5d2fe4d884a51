import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.face.animation.action_units import load_action_units, load_emotions
from conf.face.animation.timed_expression import (
    LIDS,
    LIDS_CLOSED,
    PARTS,
    SIDE_LAG,
    Envelope,
    TimedExpression,
    add_motions,
    blend_without_doubling,
    smooth_rise,
)
from conf.face.control_points import CONTROL_POINT_COUNT, CONTROL_POINT_INDEX

seconds = st.floats(0.05, 3.0)
envelopes = st.builds(Envelope, seconds, st.floats(0, 3), seconds, st.floats(-1, 1.5))


@given(envelope=envelopes, elapsed=st.floats(-1, 10))
def test_an_envelope_is_bounded_and_continuous(envelope: Envelope, elapsed: float) -> None:
    intensity = envelope(elapsed)
    assert abs(intensity) <= abs(envelope.intensity)
    assert abs(envelope(elapsed + 1e-4) - intensity) < 1e-4 * 1.5 / 0.05 * 1.5 + 1e-9
    assert envelope(-0.001) == 0.0
    assert envelope(envelope.duration + 0.001) == pytest.approx(0.0, abs=1e-9)
    assert envelope(envelope.onset + envelope.hold / 2) == pytest.approx(envelope.intensity)


def test_an_infinite_hold() -> None:
    envelope = Envelope(hold=math.inf)
    assert envelope(1e6) == 1.0
    assert envelope.duration == math.inf


@pytest.mark.slow
@given(now=st.floats(-1, 5), released_at=st.floats(0, 3))
def test_an_expression_is_continuous(now: float, released_at: float) -> None:
    joy = load_emotions()["joy"]
    expression = TimedExpression(joy, start=0.2).released(released_at)
    step = np.abs(expression.at(now + 1e-4) - expression.at(now)).max()
    assert step < 1e-4 * np.abs(joy).max() * (1.5 / 0.4 + 1.5 / 0.8) + 0.05


def test_an_expression_rises_holds_and_falls() -> None:
    joy = load_emotions()["joy"]
    expression = TimedExpression(joy, start=10.0, envelope=Envelope(0.4, 1.0, 0.5, 0.5))
    assert not expression.at(9.9).any()
    np.testing.assert_allclose(expression.at(11.0), 0.5 * joy, rtol=1e-5, atol=1e-4)
    assert not expression.is_finished(11.8)
    assert expression.is_finished(12.0)
    assert not expression.at(12.0).any()


def test_the_right_side_starts_later() -> None:
    expression = TimedExpression(load_emotions()["joy"], start=0.0)
    moved = np.abs(expression.at(0.1))
    assert moved[CONTROL_POINT_INDEX["outer_lip_corner_l"], 1] > moved[CONTROL_POINT_INDEX["outer_lip_corner_r"], 1] > 0
    assert 0 < SIDE_LAG < 0.1


def test_a_released_expression_fades_out() -> None:
    expression = TimedExpression(load_emotions()["fear"], start=0.0, envelope=Envelope(hold=math.inf, release=0.5))
    assert not expression.is_finished(1e6)
    released = expression.released(100.0)
    np.testing.assert_array_equal(released.at(100.0), expression.at(100.0))
    assert released.is_finished(100.6)
    assert not released.at(100.6).any()
    assert released.released(200.0) == released


def test_motions_add_and_lids_do_not_cross() -> None:
    blink = load_action_units()[45]
    still = np.zeros((CONTROL_POINT_COUNT, 3), np.float32)
    np.testing.assert_array_equal(add_motions(blink, still), blink)
    twice = add_motions(blink, blink, load_action_units()[7])
    for upper, lower in LIDS:
        assert twice[upper, 1] - twice[lower, 1] == pytest.approx(LIDS_CLOSED)
    np.testing.assert_allclose(
        twice[CONTROL_POINT_INDEX["brow_top_l"]], 2 * blink[CONTROL_POINT_INDEX["brow_top_l"]], atol=1
    )


def test_blending_adds_only_what_is_missing() -> None:
    joy, brows = load_emotions()["joy"], load_action_units()[1]
    assert sorted(index for part in PARTS for index in part) == list(range(CONTROL_POINT_COUNT))
    still = np.zeros_like(joy)
    np.testing.assert_allclose(blend_without_doubling(still, joy), joy, atol=1e-3)
    np.testing.assert_array_equal(blend_without_doubling(joy, still), joy)
    np.testing.assert_allclose(blend_without_doubling(0.6 * joy, joy), joy, atol=1e-3)
    np.testing.assert_allclose(blend_without_doubling(joy, 0.3 * joy), joy, atol=1e-3)
    mouth = CONTROL_POINT_INDEX["outer_lip_corner_l"]
    np.testing.assert_allclose(blend_without_doubling(brows, joy)[mouth], joy[mouth] + brows[mouth], atol=1e-3)
    assert blend_without_doubling(-joy, joy) == pytest.approx(still), "an opposite expression is cancelled"


def test_smooth_rise_of_length_0_is_a_step() -> None:
    assert (smooth_rise(-1e-9, 0.0), smooth_rise(0.0, 0.0)) == (0.0, 1.0)
    assert smooth_rise(0.5, 1.0) == pytest.approx(0.5)


@pytest.mark.parametrize("change", [{"onset": -1.0}, {"hold": -1.0}, {"release": math.inf}])
def test_an_invalid_envelope_is_an_error(change: dict[str, float]) -> None:
    with pytest.raises(ValueError, match="must not be negative"):
        Envelope(**change)


def test_an_infinite_intensity_is_an_error() -> None:
    with pytest.raises(ValueError, match="intensity must be finite"):
        Envelope(intensity=math.nan)
