"""tools/bench/voice_devices.py finds the delay between two recordings, and the gaps in one, that were put in."""

import numpy as np
import pytest

from conf.audio.samples import SAMPLE_RATE
from tools.bench.voice_devices import PIECE_S, SETTLE_S, count_gaps, lags

SECONDS = SETTLE_S + 4 * PIECE_S


@pytest.mark.parametrize("offset_s", [-1.5, -0.02, 0.0, 0.3])
def test_lags_are_those_of_the_sound_whenever_the_recordings_began(offset_s: float) -> None:
    rng = np.random.default_rng(1)
    captured = rng.normal(0, 3000, int(SECONDS * SAMPLE_RATE)).astype(np.int16)
    shift = round((0.21 - offset_s) * SAMPLE_RATE)  # samples of the second recording before the sound is heard
    heard = np.concatenate([np.zeros(max(shift, 0), np.int16), captured[max(-shift, 0) :]])
    found = lags(captured, heard, offset_s)
    assert found and found == pytest.approx([0.21] * len(found), abs=0.001)


def test_silence_has_no_lag() -> None:
    silence = np.zeros(int(SECONDS * SAMPLE_RATE), np.int16)
    assert lags(silence, silence, 0.0) == []


def test_gaps_are_interruptions_of_the_sound() -> None:
    sound = np.random.default_rng(2).normal(0, 3000, SAMPLE_RATE).astype(np.int16)
    assert count_gaps(sound) == 0
    sound[4000:4100] = 0
    sound[8000:8016] = 1
    assert count_gaps(sound) == count_gaps(np.concatenate([sound, np.zeros(400, np.int16)])) == 2
    fading = (sound[:4000] * np.linspace(1, 0, 4000) ** 4).astype(np.int16)
    assert count_gaps(np.concatenate([fading, np.zeros(800, np.int16), fading[::-1]])) == 0
