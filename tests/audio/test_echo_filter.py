"""The filter learns a response, keeps it under a near voice, and expects its own error rightly."""

import numpy as np
import pytest
from numpy.typing import NDArray

from conf.audio.echo_filter import BLOCK, PARTITIONS, EchoFilter
from conf.audio.samples import FULL_SCALE, SAMPLE_RATE
from tests.support.synthetic_voice import whisper
from tools.bench.rooms import Scene, simulate_echo

PLAYED = whisper(4.0, seed=1, dbfs=-20)
ECHO = simulate_echo(PLAYED, Scene("desk", delay_s=0.01), dbfs=-26) / FULL_SCALE


def run(echo_filter: EchoFilter, recorded: NDArray[np.float64]) -> NDArray[np.float32]:
    """Return the estimated echo."""
    played = np.concatenate([np.zeros(BLOCK), PLAYED / FULL_SCALE]).astype(np.float32)
    near = recorded.astype(np.float32)
    return np.concatenate(
        [
            echo_filter.process(near[first : first + BLOCK], played[first : first + 2 * BLOCK])
            for first in range(0, len(near) - BLOCK + 1, BLOCK)
        ]
    )


def reduction_db(echo: NDArray[np.floating], rest: NDArray[np.floating]) -> float:
    return float(10 * np.log10(np.square(echo).sum() / np.square(rest).sum()))


def test_a_known_response_is_found_exactly() -> None:
    """Two impulses in different partitions."""
    played = np.random.default_rng(1).normal(0, 0.1, 2 * SAMPLE_RATE)
    response = np.zeros(BLOCK * 3)
    response[100], response[2 * BLOCK + 17] = 0.5, -0.2
    echo = np.convolve(played, response)[: len(played)].astype(np.float32)
    echo_filter = EchoFilter()
    sound = np.concatenate([np.zeros(BLOCK), played]).astype(np.float32)
    for first in range(0, len(played), BLOCK):
        estimate = echo_filter.process(echo[first : first + BLOCK], sound[first : first + 2 * BLOCK])
    assert reduction_db(echo[-BLOCK:], echo[-BLOCK:] - estimate) > 40


def test_a_room_is_learned_within_two_seconds() -> None:
    estimate = run(EchoFilter(), ECHO)
    last = slice(2 * SAMPLE_RATE, None)
    assert reduction_db(ECHO[last], ECHO[last] - estimate[last]) > 20


def test_a_near_voice_does_not_disturb_what_was_learned() -> None:
    near = np.zeros(len(ECHO))
    near[2 * SAMPLE_RATE :] = whisper(2.0, seed=2, dbfs=-20) / FULL_SCALE
    estimate = run(EchoFilter(), ECHO + near)
    last = slice(2 * SAMPLE_RATE, None)
    assert reduction_db(ECHO[last], ECHO[last] - estimate[last]) > 15


def test_the_power_of_the_rest_is_not_underestimated() -> None:
    echo_filter = EchoFilter()
    run(echo_filter, ECHO[: 2 * SAMPLE_RATE])
    expected, found = 0.0, 0.0
    played = (PLAYED / FULL_SCALE).astype(np.float32)
    for first in range(2 * SAMPLE_RATE, 3 * SAMPLE_RATE, BLOCK):
        block = ECHO[first : first + BLOCK].astype(np.float32)
        rest = block - echo_filter.process(block, played[first - BLOCK : first + BLOCK])
        expected += float(echo_filter.residual_power.sum())
        found += float((np.abs(np.fft.rfft(rest, 2 * BLOCK)) ** 2).sum())
    assert 1 < expected / found < 100


def test_a_reset_forgets_and_a_louder_echo_is_learned_with_a_ratio() -> None:
    echo_filter = EchoFilter()
    run(echo_filter, ECHO)
    echo_filter.reset(20.0)
    zero = echo_filter.process(np.zeros(BLOCK, np.float32), (PLAYED[: 2 * BLOCK] / FULL_SCALE).astype(np.float32))
    assert not zero.any()
    estimate = run(echo_filter, 10 * ECHO)
    last = slice(2 * SAMPLE_RATE, None)
    assert reduction_db(10 * ECHO[last], 10 * ECHO[last] - estimate[last]) > 25


def test_after_a_pause_the_history_can_be_set() -> None:
    """The filter that missed some blocks continues as the one that heard them."""
    heard, resumed = EchoFilter(), EchoFilter()
    half = 2 * SAMPLE_RATE
    for echo_filter in (heard, resumed):
        run(echo_filter, ECHO[:half])
    played = (PLAYED / FULL_SCALE).astype(np.float32)
    resumed.set_history(played[half - (PARTITIONS + 1) * BLOCK : half])
    block = ECHO[half : half + BLOCK].astype(np.float32)
    estimates = [each.process(block, played[half - BLOCK : half + BLOCK]) for each in (heard, resumed)]
    assert estimates[0] == pytest.approx(estimates[1], abs=1e-6)


def later(samples: int) -> NDArray[np.float64]:
    """Return an echo that is late from 3 s on."""
    return np.concatenate([ECHO[: 3 * SAMPLE_RATE], ECHO[3 * SAMPLE_RATE - samples :]])


@pytest.mark.parametrize("near_dbfs", [-90.0, -20.0])
def test_an_echo_that_jumps_is_noticed_and_not_learned(near_dbfs: float) -> None:
    near = np.zeros(len(ECHO))
    near[2 * SAMPLE_RATE :] = whisper(2.0, seed=2, dbfs=near_dbfs) / FULL_SCALE
    echo_filter, stop = EchoFilter(), 3 * SAMPLE_RATE
    run(echo_filter, (ECHO + near)[:stop])
    assert echo_filter.is_fitting and not echo_filter.is_doubtful and not echo_filter.is_lost
    played = (PLAYED / FULL_SCALE).astype(np.float32)
    recorded = (later(100)[: len(near)] + near).astype(np.float32)
    for first in range(stop, stop + 5 * BLOCK, BLOCK):
        echo_filter.process(recorded[first : first + BLOCK], played[first - BLOCK : first + BLOCK])
    assert echo_filter.is_lost and echo_filter.is_doubtful and not echo_filter.is_fitting
    before = echo_filter.response
    echo_filter.process(recorded[first : first + BLOCK], played[first - BLOCK : first + BLOCK])
    np.testing.assert_array_equal(echo_filter.response, before)


def test_what_was_learned_can_be_delayed_by_a_part_of_a_sample_and_made_quieter() -> None:
    echo_filter = EchoFilter()
    run(echo_filter, ECHO)
    before = echo_filter.response
    echo_filter.change_response(1.0, 0.5)
    np.testing.assert_allclose(echo_filter.response[1:], before[:-1] / 2, atol=1e-6)
    echo_filter.change_response(-0.5, 2.0)
    echo_filter.change_response(-0.5, 1.0)
    np.testing.assert_allclose(echo_filter.response[:-1], before[:-1], atol=2e-3)
