"""The delay of an echo is found in rooms, under near voices, after a change, and not where there is none."""

import numpy as np
import pytest
from scipy.signal.windows import tukey

from conf.audio.echo_delay import DelayFinder, tapered_cosine
from conf.audio.samples import FULL_SCALE, SAMPLE_RATE, Samples, to_int16
from tests.support.synthetic_voice import noise, tone, whisper
from tools.bench.rooms import ROOMS, Scene, simulate_echo

BLOCK = 320
PLAYED = whisper(4.0, seed=1, dbfs=-20)


def run(finder: DelayFinder, recorded: Samples, played: Samples = PLAYED) -> list[tuple[float, int | None]]:
    """Return the changes: time, s, and the new delay."""
    changes = []
    near, far = (sound.astype(np.float32) / np.float32(FULL_SCALE) for sound in (recorded, played))
    for first in range(0, len(near) - BLOCK + 1, BLOCK):
        if finder.update(near[first : first + BLOCK], far[first : first + BLOCK]):
            changes.append(((first + BLOCK) / SAMPLE_RATE, finder.delay))
    return changes


@pytest.mark.parametrize("room", ROOMS)
@pytest.mark.parametrize("delay_s", [0.02, 0.06, 0.12, 0.2])
def test_the_delay_of_every_room_is_found_within_a_second(room: str, delay_s: float) -> None:
    finder = DelayFinder()
    changes = run(finder, to_int16(simulate_echo(PLAYED, Scene(room, delay_s), dbfs=-32)))
    assert len(changes) == 1
    at, delay = changes[0]
    assert at <= 1.1
    assert delay == pytest.approx(delay_s * SAMPLE_RATE, abs=8)
    assert finder.confidence > 11


def test_it_is_found_under_a_near_voice_twice_as_loud() -> None:
    echo = simulate_echo(PLAYED, Scene(delay_s=0.06), dbfs=-32)
    finder = DelayFinder()
    changes = run(finder, to_int16(echo + whisper(4.0, seed=2, dbfs=-26)))
    assert [delay for _, delay in changes] == [pytest.approx(960, abs=8)]
    assert changes[0][0] < 3


def test_a_change_is_found() -> None:
    scene = Scene("desk", delay_s=0.06, later_delay_s=0.11, change_s=2.0)
    changes = run(DelayFinder(), to_int16(simulate_echo(PLAYED, scene, dbfs=-32)))
    assert [delay for _, delay in changes] == [pytest.approx(960, abs=8), pytest.approx(1760, abs=8)]
    assert changes[1][0] < 3.8


def test_after_a_restart_the_delay_given_stays_until_a_change_is_found() -> None:
    recorded = to_int16(simulate_echo(PLAYED, Scene("desk", 0.11), dbfs=-32))
    finder = DelayFinder()
    run(finder, recorded[:32000], PLAYED[:32000])
    finder.restart(960)
    assert finder.delay == 960
    changes = run(finder, recorded[32000:], PLAYED[32000:])
    assert changes[0][0] < 1.1 and changes[0][1] == pytest.approx(1760, abs=8)


def test_drifting_clocks_are_followed_without_a_change() -> None:
    finder = DelayFinder()
    changes = run(finder, to_int16(simulate_echo(PLAYED, Scene("desk", 0.06, drift_ppm=-400), dbfs=-32)))
    assert len(changes) == 1
    assert finder.delay == pytest.approx(960 + 0.0004 * 3.7 * SAMPLE_RATE, abs=5)


@pytest.mark.parametrize(
    "recorded", [whisper(4.0, seed=3), noise(4.0, -40), np.zeros(64000, np.int16)], ids=["voice", "noise", "silence"]
)
def test_without_an_echo_there_is_no_delay(recorded: Samples) -> None:
    finder = DelayFinder()
    assert run(finder, recorded) == []
    assert finder.delay is None


def test_the_same_hum_at_both_ends_is_no_echo() -> None:
    """Both rooms hum with the harmonics of the mains."""
    hum = sum((tone(hertz, 4.0, amplitude=40) for hertz in range(250, 1000, 50)), np.zeros(64000, np.int16))
    finder = DelayFinder()
    assert run(finder, hum + noise(4.0, -60, seed=1), hum + noise(4.0, -60, seed=2)) == []


def test_silence_of_the_loudspeaker_changes_nothing() -> None:
    finder = DelayFinder()
    run(finder, to_int16(simulate_echo(PLAYED, Scene(delay_s=0.06), dbfs=-32)))
    assert run(finder, whisper(4.0, seed=4), np.zeros(64000, np.int16)) == []
    assert finder.delay == pytest.approx(960, abs=8)


@pytest.mark.parametrize(("size", "tapered"), [(8, 0.5), (1001, 0.25), (64, 1.0)])
def test_the_window_is_scipys(size: int, tapered: float) -> None:
    np.testing.assert_allclose(tapered_cosine(size, tapered), tukey(size, tapered), atol=1e-6)
