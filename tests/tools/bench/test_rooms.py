"""The simulated rooms have the properties that they claim."""

import numpy as np
import pytest

from conf.audio.samples import SAMPLE_RATE, to_int16
from tests.support.synthetic_voice import tone, whisper
from tools.bench.rooms import ROOMS, Scene, active_dbfs, room_response, simulate_echo, stretch


@pytest.mark.slow
@pytest.mark.parametrize("name", ROOMS)
def test_energy_decays_by_60_db_in_the_reverberation_time(name: str) -> None:
    """By Schroeder's backward integration, between -5 and -25 dB."""
    room = ROOMS[name]
    response = room_response(room)
    assert response @ response == pytest.approx(1)
    assert np.abs(response[:3]).max() > 0.1  # the direct sound
    decay = 10 * np.log10(np.cumsum(response[::-1] ** 2)[::-1])
    start, stop = int(np.argmax(decay < -5)), int(np.argmax(decay < -25))
    assert 3 * (stop - start) / SAMPLE_RATE == pytest.approx(room.reverberation_s, rel=0.35)


def test_the_echo_has_its_level_and_its_delay() -> None:
    played = whisper(2.0, seed=1)
    echo = simulate_echo(played, Scene("desk", 0.1), dbfs=-32)
    assert active_dbfs(to_int16(echo)) == pytest.approx(-32, abs=1)
    assert not echo[:1600].any() and echo[1600:1700].any()


def test_the_delay_changes() -> None:
    played = whisper(1.0, seed=1)
    before, after = (simulate_echo(played, Scene("desk", delay_s), dbfs=-32) for delay_s in (0.02, 0.05))
    both = simulate_echo(played, Scene("desk", 0.02, later_delay_s=0.05, change_s=0.5), dbfs=-32)
    np.testing.assert_array_equal(both, np.concatenate([before[:8000], after[8000:]]))


def test_a_slower_clock_hears_a_higher_pitch() -> None:
    sound = stretch(tone(1000, 2.0).astype(float), 500.0)
    expected = 8000 * np.sin(2 * np.pi * 1000 * 1.0005 * np.arange(len(sound)) / SAMPLE_RATE)
    assert np.abs(sound - expected)[100:30000].max() < 20


def test_distortion_adds_harmonics() -> None:
    played = tone(500, 1.0, amplitude=16000)
    clean, distorted = (
        np.abs(np.fft.rfft(simulate_echo(played, Scene("desk", 0.0, distortion=d), dbfs=-26)[8000:])) for d in (0, 1)
    )
    assert clean[750] < 1e-2 * clean[250]
    assert 3e-2 < distorted[750] / distorted[250] < 0.3
