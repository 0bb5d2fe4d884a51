"""An echo that has jumped is found by what was learned of it, also under a near voice, and none by chance."""

import numpy as np
import pytest
from numpy.typing import NDArray

from conf.audio.echo_shift import REACH, Shift, find_shift
from conf.audio.samples import FULL_SCALE, SAMPLE_RATE, Samples
from tests.support.synthetic_voice import noise, whisper
from tools.bench.rooms import ROOMS, room_response

COUNT = 3 * 320  # 60 ms
RESPONSE = (0.5 * room_response(ROOMS["office"])[:3840]).astype(np.float32)
START = 4 * SAMPLE_RATE // 2  # of what was recorded
PLAYED = whisper(4.0, seed=1, dbfs=-20)


def as_float(sound: Samples) -> NDArray[np.float32]:
    return sound.astype(np.float32) / np.float32(FULL_SCALE)


def recorded_echo(shift: float) -> NDArray[np.float32]:
    spectrum = np.fft.rfft(as_float(PLAYED)) * np.fft.rfft(RESPONSE, len(PLAYED))
    spectrum *= np.exp(-2j * np.pi * np.fft.rfftfreq(len(PLAYED)) * shift)
    return np.fft.irfft(spectrum)[START : START + COUNT].astype(np.float32)


def shift_of(recorded: NDArray[np.float32], played: Samples = PLAYED) -> Shift | None:
    window = played[START - len(RESPONSE) - REACH : START + COUNT + REACH]
    return find_shift(recorded, as_float(window), RESPONSE)


@pytest.mark.parametrize("shift", [-1600.0, -320.0, -11.4, 0.0, 0.7, 9.5, 480.3, 2300.0])
def test_60_ms_tell_the_shift_to_a_fifth_of_a_sample(shift: float) -> None:
    found = shift_of(recorded_echo(shift) + as_float(noise(0.06, -72)[:COUNT]))
    assert found is not None
    assert found.samples == pytest.approx(shift, abs=0.2) and found.gain == pytest.approx(1, abs=0.35)


@pytest.mark.parametrize("seed", range(4))
def test_a_near_voice_as_loud_as_the_echo_does_not_hide_it(seed: int) -> None:
    echo = recorded_echo(300.0)
    near = as_float(whisper(0.06, seed=10 + seed)[:COUNT])
    near *= np.sqrt((echo @ echo) / (near @ near))
    found = shift_of(0.5 * echo + 0.5 * near)
    assert found is not None
    assert found.samples == pytest.approx(300, abs=0.5) and found.gain == pytest.approx(0.5, abs=0.15)


@pytest.mark.parametrize("seed", range(8))
def test_a_near_voice_without_an_echo_is_no_shift(seed: int) -> None:
    assert shift_of(as_float(whisper(0.06, seed=10 + seed)[:COUNT])) is None


def test_a_shift_beyond_reach_is_none() -> None:
    assert shift_of(recorded_echo(REACH + 100.0)) is None


def test_silence_is_no_shift() -> None:
    silence = np.zeros(COUNT, np.float32)
    assert shift_of(silence) is None
    assert shift_of(recorded_echo(0.0), np.zeros_like(PLAYED)) is None
    assert shift_of(silence, np.zeros_like(PLAYED)) is None
