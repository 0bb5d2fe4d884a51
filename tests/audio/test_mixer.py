"""Mixing: sums, the limit, who is loudest."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.typing import NDArray

from conf.audio.mixer import Mixer, soft_limit
from conf.audio.samples import Samples
from tests.support.synthetic_voice import tone

SILENCE = np.zeros(320, np.int16)


def loudest_after(mixer: Mixer[str], blocks: dict[str, Samples], seconds: float) -> str | None:
    return [mixer.mix(blocks).loudest for _ in range(round(seconds / 0.02))][-1]


def test_quiet_talkers_are_added_exactly() -> None:
    one, two = tone(300, 0.02, amplitude=5000), tone(450, 0.02, amplitude=6000)
    np.testing.assert_array_equal(Mixer[str]().mix({"a": one, "b": two}).samples, one + two)


@pytest.mark.parametrize("peak", [-32768, -22938, -22937, 0, 22937, 22938, 32767])
def test_one_talker_is_mixed_as_among_silent_ones(peak: int) -> None:
    one = np.array([peak, peak // 2, 100, -100], np.int16)
    alone, among = Mixer[str]().mix({"a": one}), Mixer[str]().mix({"a": one, "b": np.zeros_like(one)})
    np.testing.assert_array_equal(alone.samples, among.samples)
    assert alone.loudest == among.loudest and alone.samples.dtype == np.int16


def test_loud_talkers_bend_and_do_not_wrap() -> None:
    loud = tone(300, 0.02, amplitude=30000)
    mixed = Mixer[int]().mix({1: loud, 2: loud, 3: loud}).samples.astype(int)
    assert 32000 < mixed.max() <= 32767
    assert (np.sign(mixed) == np.sign(loud)).all()


@given(arrays(np.float64, 20, elements=st.floats(-200000, 200000)))
def test_the_limit_keeps_order_sign_and_range(values: NDArray[np.float64]) -> None:
    limited = soft_limit(np.sort(values))
    assert (np.diff(limited) >= 0).all() and np.abs(limited).max() <= 32767
    assert (np.abs(limited) <= np.abs(np.sort(values)) + 1e-9).all()


def test_nobody_and_silence() -> None:
    mixed = Mixer[str]().mix({})
    assert len(mixed.samples) == 0 and mixed.loudest is None
    assert Mixer[str]().mix({"a": SILENCE}).loudest is None


def test_the_loudest_is_named_and_stays_until_another_is_3_db_louder() -> None:
    mixer = Mixer[str]()
    assert loudest_after(mixer, {"a": tone(300, 0.02, amplitude=4000), "b": SILENCE}, 0.2) == "a"
    assert (
        loudest_after(mixer, {"a": tone(300, 0.02, amplitude=4000), "b": tone(300, 0.02, amplitude=5000)}, 2.0) == "a"
    )
    assert (
        loudest_after(mixer, {"a": tone(300, 0.02, amplitude=4000), "b": tone(300, 0.02, amplitude=7000)}, 2.0) == "b"
    )
    assert loudest_after(mixer, {"a": SILENCE, "b": SILENCE}, 3.0) is None


def test_a_short_pause_does_not_change_the_loudest() -> None:
    mixer = Mixer[str]()
    loudest_after(mixer, {"a": tone(300, 0.02, amplitude=9000), "b": tone(300, 0.02, amplitude=300)}, 1.0)
    assert loudest_after(mixer, {"a": SILENCE, "b": tone(300, 0.02, amplitude=300)}, 0.06) == "a"


def test_who_left_is_forgotten() -> None:
    mixer = Mixer[str]()
    loudest_after(mixer, {"a": tone(300, 0.02), "b": SILENCE}, 0.2)
    assert mixer.mix({"b": SILENCE}).loudest is None


def test_blocks_must_have_one_length() -> None:
    with pytest.raises(ValueError, match="blocks must have one length"):
        Mixer[str]().mix({"a": SILENCE, "b": SILENCE[:160]})
