"""The echo of simulated rooms is removed, near voices are kept, times are kept, and nothing happens without an echo."""

from collections.abc import Sequence
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pystoi import stoi

from conf.audio.echo_canceller import DELAY_S, EchoCanceller
from conf.audio.echo_filter import BLOCK
from conf.audio.samples import SAMPLE_RATE, AudioBlock, Samples, level_dbfs, to_int16
from tests.support.synthetic_voice import noise, whisper
from tools.bench.rooms import Scene, room_noise, simulate_echo

START = 50.0
PLAYED = whisper(7.0, seed=1, dbfs=-20)
NEAR_FROM = 4 * SAMPLE_RATE
NEAR = whisper(3.0, seed=2, dbfs=-26)
LATE = round(DELAY_S * SAMPLE_RATE)


def run(canceller: EchoCanceller, recorded: Samples, played: Samples = PLAYED, *, start: float = START) -> Samples:
    parts = []
    for first in range(0, len(recorded), BLOCK):
        at = start + first / SAMPLE_RATE
        reference = AudioBlock(at, played[first : first + BLOCK])
        parts.append(canceller.process(AudioBlock(at, recorded[first : first + BLOCK]), reference).samples)
    return np.concatenate(parts)


def echo_of(scene: Scene) -> Samples:
    return to_int16(simulate_echo(PLAYED, scene, dbfs=-26 + scene.echo_db) + room_noise(len(PLAYED)))


@pytest.mark.slow
@pytest.mark.parametrize(("room", "delay_s"), [("desk", 0.02), ("office", 0.12), ("living", 0.06), ("living", 0.2)])
def test_after_3_s_the_echo_is_30_db_quieter(room: str, delay_s: float) -> None:
    echo = echo_of(Scene(room, delay_s))
    canceller = EchoCanceller()
    output = run(canceller, echo)
    assert level_dbfs(output[3 * SAMPLE_RATE :]) < level_dbfs(echo[3 * SAMPLE_RATE :]) - 30
    assert canceller.delay_s == pytest.approx(delay_s, abs=0.001)


@pytest.mark.slow
@pytest.mark.parametrize(("delay_s", "echo_db"), [(0.02, -6), (0.2, -6), (0.06, 0)])
def test_the_near_voice_is_kept_in_double_talk(delay_s: float, echo_db: float) -> None:
    recorded = echo_of(Scene("office", delay_s, echo_db)).astype(float)
    recorded[NEAR_FROM:] += NEAR
    output = run(EchoCanceller(), to_int16(recorded))
    heard = output[NEAR_FROM + LATE :].astype(float)
    found = stoi(NEAR[: len(heard)].astype(float), heard, SAMPLE_RATE)
    assert found > 0.9
    assert found > stoi(NEAR.astype(float), recorded[NEAR_FROM:], SAMPLE_RATE) + 0.05


@pytest.mark.slow
def test_a_new_delay_is_found_and_learned() -> None:
    echo = echo_of(Scene("desk", 0.06, later_delay_s=0.15, change_s=3.0))
    canceller = EchoCanceller()
    output = run(canceller, echo)
    assert canceller.delay_s == pytest.approx(0.15, abs=0.001)
    assert level_dbfs(output[5 * SAMPLE_RATE :]) < level_dbfs(echo[5 * SAMPLE_RATE :]) - 25


@pytest.mark.slow
def test_without_an_echo_the_voice_passes() -> None:
    """With headphones: what is played is not heard."""
    canceller = EchoCanceller()
    sound = to_int16(np.tile(NEAR, 2) + room_noise(2 * len(NEAR)))
    output = run(canceller, sound, PLAYED[: len(sound)])
    assert canceller.delay_s is None
    np.testing.assert_allclose(output[LATE:], sound[:-LATE], atol=1)


def test_without_a_loudspeaker_the_sound_passes_late() -> None:
    canceller = EchoCanceller()
    sound = NEAR[:9600]
    first = canceller.process(AudioBlock(START, sound))
    assert first.timestamp == pytest.approx(START - DELAY_S)
    np.testing.assert_allclose(first.samples[LATE:], sound[:-LATE], atol=1)


def test_while_the_loudspeaker_is_silent_the_sound_passes() -> None:
    output = run(EchoCanceller(), NEAR, np.zeros(len(NEAR), np.int16))
    np.testing.assert_allclose(output[LATE:], NEAR[:-LATE], atol=1)


@pytest.mark.slow
@given(counts=st.lists(st.integers(0, 900), max_size=6))
def test_blocks_of_any_length_give_the_same_sound_with_times_that_go_on(counts: list[int]) -> None:
    canceller, parts, position = EchoCanceller(), list[AudioBlock](), 0
    for count in counts:
        at = START + position / SAMPLE_RATE
        reference = AudioBlock(at, PLAYED[position : position + count])
        parts.append(canceller.process(AudioBlock(at, NEAR[position : position + count]), reference))
        position += count
    expected = run(EchoCanceller(), NEAR[: position // BLOCK * BLOCK]) if position >= BLOCK else NEAR[:0]
    np.testing.assert_array_equal(np.concatenate([NEAR[:0], *(part.samples for part in parts)]), expected)
    ends = [START - DELAY_S, *(part.end for part in parts)]
    assert [part.timestamp for part in parts] == pytest.approx(ends[:-1])


def test_the_microphone_waits_for_a_late_reference_but_not_for_long() -> None:
    canceller = EchoCanceller()
    canceller.process(AudioBlock(START, NEAR[:BLOCK]), AudioBlock(START, PLAYED[:BLOCK]))
    late = canceller.process(AudioBlock(START + 0.02, NEAR[BLOCK : 3 * BLOCK]), None)
    assert len(late.samples) == 0
    both = canceller.process(
        AudioBlock(START + 0.06, NEAR[3 * BLOCK : 4 * BLOCK]), AudioBlock(START + 0.02, PLAYED[BLOCK : 4 * BLOCK])
    )
    assert len(both.samples) == 3 * BLOCK and both.timestamp == pytest.approx(START + 0.02 - DELAY_S)
    stopped = canceller.process(AudioBlock(START + 0.08, NEAR[: 20 * BLOCK]), None)
    assert len(stopped.samples) == 20 * BLOCK


def test_a_gap_of_the_microphone_drops_what_fills_no_block() -> None:
    canceller = EchoCanceller()
    canceller.process(AudioBlock(START, NEAR[: BLOCK + 100]))
    after = canceller.process(AudioBlock(START + 1, NEAR[:BLOCK]))
    assert after.timestamp == pytest.approx(START + 1 - DELAY_S) and len(after.samples) == BLOCK


@pytest.mark.slow
def test_a_delay_that_is_found_with_the_first_block_after_a_gap_needs_nothing_heard_before() -> None:
    canceller = EchoCanceller()
    canceller._finder = SimpleNamespace(delay=960, update=lambda recorded, played: True)  # type: ignore[assignment]
    blocks = (AudioBlock(START + at, np.zeros(BLOCK, np.int16)) for at in (0.0, 0.02, 3.0))
    assert [len(canceller.process(block, block).samples) for block in blocks] == [BLOCK] * 3


def jumping_echo(jumps: Sequence[tuple[float, int]], *, delay: int = 1600) -> Samples:
    """Return an echo whose delay changes at some times, s, by some samples, as if devices lost sound."""
    echo = simulate_echo(PLAYED, Scene("office", 0.0), dbfs=-32)
    recorded = np.zeros(len(echo))
    for at, samples in [(0.0, 0), *jumps]:
        delay += samples
        first = round(at * SAMPLE_RATE)
        recorded[first:] = np.concatenate([np.zeros(delay), echo])[first : len(echo)]
    return to_int16(recorded + room_noise(len(recorded)))


@pytest.mark.slow
@pytest.mark.parametrize("jump", [-1600, -480, -11, 11, 320, 1600])  # 0.7 to 100 ms
def test_an_echo_that_jumps_is_gone_again_after_a_tenth_of_a_second(jump: int) -> None:
    echo = jumping_echo([(3.0, jump), (5.0, -jump)], delay=2000)
    output = run(EchoCanceller(), echo)
    for first, last in ((3.12, 5.0), (5.12, 7.0)):
        part = slice(round(first * SAMPLE_RATE), round(last * SAMPLE_RATE))
        assert level_dbfs(output[part]) < level_dbfs(echo[part]) - 30


@pytest.mark.slow
def test_a_volume_turned_down_is_followed() -> None:
    echo = echo_of(Scene("office", 0.06)).astype(float)
    echo[4 * SAMPLE_RATE :] *= 0.4
    recorded = to_int16(echo + room_noise(len(echo), seed=2))
    output, later = run(EchoCanceller(), recorded), round(4.12 * SAMPLE_RATE)
    assert level_dbfs(output[later:]) < level_dbfs(recorded[later:]) - 25


def run_with_late_stamps(canceller: EchoCanceller, echo: np.ndarray, *, from_s: float, late_s: float) -> np.ndarray:
    """Return what is left of an echo when the time stamps of the played sound are late from a time on."""
    parts = []
    for first in range(0, len(echo), BLOCK):
        at = START + first / SAMPLE_RATE
        played = AudioBlock(at + (late_s if first >= from_s * SAMPLE_RATE else 0.0), PLAYED[first : first + BLOCK])
        parts.append(canceller.process(AudioBlock(at, echo[first : first + BLOCK]), played).samples)
    return np.concatenate(parts)


@pytest.mark.slow
def test_a_near_voice_is_kept_while_the_echo_jumps() -> None:
    echo = jumping_echo([(4.5, 400), (5.5, -900)]).astype(float)
    echo[NEAR_FROM:] += NEAR
    heard = run(EchoCanceller(), to_int16(echo))[NEAR_FROM + LATE :].astype(float)
    assert stoi(NEAR[: len(heard)].astype(float), heard, SAMPLE_RATE) > 0.9


@pytest.mark.slow
def test_time_stamps_that_tell_of_a_jump_late_do_not_move_the_window() -> None:
    """A loudspeaker that got nothing to play for 20 ms is noticed half a second later."""
    echo, canceller = jumping_echo([(4.0, 320)]), EchoCanceller()
    output, later = run_with_late_stamps(canceller, echo, from_s=4.5, late_s=0.02), round(4.12 * SAMPLE_RATE)
    assert level_dbfs(output[later:]) < level_dbfs(echo[later:]) - 30
    assert canceller.delay_s == pytest.approx(0.1, abs=0.001)


@pytest.mark.slow
def test_a_loudspeaker_that_got_nothing_to_play_for_a_while_keeps_what_was_learned() -> None:
    echo = echo_of(Scene("desk", 0.06, later_delay_s=0.07, change_s=4.0))
    output = run_with_late_stamps(EchoCanceller(), echo, from_s=4.0, late_s=0.01)
    later = round(4.4 * SAMPLE_RATE)
    assert level_dbfs(output[later:]) < level_dbfs(echo[later:]) - 30


def test_a_gap_of_the_loudspeaker_is_survived() -> None:
    canceller = EchoCanceller()
    echo = echo_of(Scene("desk", 0.06))
    run(canceller, echo)
    later = run(canceller, echo, start=START + 9)
    assert level_dbfs(later[SAMPLE_RATE:]) < level_dbfs(echo[SAMPLE_RATE:]) - 25


def test_noise_alone_keeps_its_level() -> None:
    sound = noise(2.0, -50)
    output = run(EchoCanceller(), sound, np.zeros(len(sound), np.int16))
    assert level_dbfs(output[LATE:]) == pytest.approx(-50, abs=0.2)
