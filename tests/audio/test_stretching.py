"""Slower and faster sound: length, pitch, no clicks, unchanged at speed 1."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.audio.samples import SAMPLE_RATE, Samples, level_dbfs
from conf.audio.stretching import TimeStretcher
from tests.support.synthetic_voice import max_jump, noise, pitch_hz, speech, tone, vowel

FRAME = SAMPLE_RATE // 50
SPEECH = speech(2.0, seed=9)
SPEEDS = (0.8, 0.9, 1.1, 1.25)


def stretch(sound: Samples, speed: float) -> Samples:
    stretcher = TimeStretcher()
    parts = []
    for start in range(0, len(sound), FRAME):
        stretcher.push(sound[start : start + FRAME])
        parts.append(stretcher.pull(10 * FRAME, speed))
    parts.append(stretcher.pull(10 * FRAME))  # the rest, unstretched
    return np.concatenate(parts)


@pytest.mark.parametrize("speed", SPEEDS)
@pytest.mark.parametrize("sound", [vowel(0, 1.5, pitch=90), vowel(2, 1.5, pitch=210), speech(1.5), noise(1.5, -30)])
def test_the_length_is_exact_within_a_frame(sound: Samples, speed: float) -> None:
    assert len(stretch(sound, speed)) == pytest.approx(len(sound) / speed, abs=FRAME)


@pytest.mark.slow
@pytest.mark.parametrize("speed", SPEEDS)
@pytest.mark.parametrize("pitch", [80.0, 120.0, 220.0, 330.0])
def test_pitch_and_level_are_kept(pitch: float, speed: float) -> None:
    sound = vowel(0, 1.5, pitch=pitch)
    stretched = stretch(sound, speed)
    assert pitch_hz(stretched, low=0.7 * pitch) == pytest.approx(pitch, rel=0.01)
    assert level_dbfs(stretched) == pytest.approx(level_dbfs(sound), abs=0.5)


@pytest.mark.parametrize("speed", SPEEDS)
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_no_sample_jumps_further_than_in_the_sound_itself(seed: int, speed: float) -> None:
    sound = speech(1.5, seed=seed)
    assert max_jump(stretch(sound, speed)) <= 1.1 * max_jump(sound)


@pytest.mark.parametrize("speed", SPEEDS)
def test_a_tone_stays_a_tone(speed: float) -> None:
    stretched = stretch(tone(440, 1.5), speed).astype(float)[FRAME:-FRAME]
    spectrum = np.abs(np.fft.rfft(stretched * np.hanning(len(stretched)))) ** 2
    peak = round(440 * len(stretched) / SAMPLE_RATE)
    assert spectrum[peak - 8 : peak + 9].sum() > 0.999 * spectrum.sum()


def test_speed_1_passes_samples_unchanged_and_at_once() -> None:
    stretcher, sound = TimeStretcher(), speech(0.5)
    for start in range(0, len(sound), 7 * FRAME):
        block = sound[start : start + 7 * FRAME]
        stretcher.push(block)
        np.testing.assert_array_equal(stretcher.pull(len(block)), block)
        assert stretcher.buffered == 0


@given(
    blocks=st.lists(
        st.tuples(st.integers(0, 700), st.integers(0, 700), st.sampled_from([0.9, 1.0, 1.0, 1.1])), max_size=25
    )
)
@pytest.mark.slow
def test_changing_speeds_keep_the_books(blocks: list[tuple[int, int, float]]) -> None:
    stretcher, sound = TimeStretcher(), SPEECH
    pushed = heard = 0
    expected = 0.0
    parts = [np.zeros(1, np.int16)]
    for push, pull, speed in blocks:
        stretcher.push(sound[pushed : pushed + push])
        pushed = min(pushed + push, len(sound))
        before = stretcher.buffered
        missing = stretcher.missing(pull, speed)
        parts.append(stretcher.pull(pull, speed))
        assert len(parts[-1]) == pull or (len(parts[-1]) < pull and missing > 0)
        heard += len(parts[-1])
        expected += before - stretcher.buffered
        assert stretcher.buffered >= -FRAME
    assert abs(expected + stretcher.buffered - pushed) < 1e-6
    assert max_jump(np.concatenate(parts)) <= 1.1 * max_jump(sound)


@pytest.mark.slow
@given(count=st.integers(1, 2000), speed=st.sampled_from([0.5, 0.9, 1.0, 1.1, 2.0]), start=st.integers(0, 2000))
def test_what_is_said_to_be_missing_suffices(count: int, speed: float, start: int) -> None:
    stretcher, sound = TimeStretcher(), SPEECH
    stretcher.push(sound[:start])
    stretcher.pull(start // 2, 1.1)
    missing = stretcher.missing(count, speed)
    stretcher.push(np.resize(sound, missing))
    assert len(stretcher.pull(count, speed)) == count
    assert stretcher.missing(0, speed) == 0


def test_input_is_not_kept_for_ever() -> None:
    stretcher = TimeStretcher()
    for i in range(300):
        stretcher.push(noise(0.02, -30, seed=i))
        stretcher.pull(FRAME, 1.1 if i % 3 else 1.0)
    assert len(stretcher._input) < 4 * FRAME


@pytest.mark.parametrize("speed", [0.4, 2.5, 0.0])
def test_a_speed_out_of_range_is_refused(speed: float) -> None:
    with pytest.raises(ValueError, match=r"speed must be from 0.5 to 2.0"):
        TimeStretcher().pull(10, speed)
