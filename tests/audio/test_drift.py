"""Sound cards that run fast, slow, late or stop: the samples stay on the clock."""

from itertools import pairwise

import numpy as np
import pytest

from conf.audio.drift import DROPOUT_S, PLAYED_DROPOUT_S, ClockAligner
from conf.audio.samples import SAMPLE_RATE, AudioBlock
from tests.support.synthetic_voice import max_jump, pitch_hz

BLOCK = 320


class Card:
    """A sound card whose tone of 200 Hz is true to the clock. ppm : how much faster its samples come"""

    def __init__(self, ppm: float, *, jitter_s: float = 0.0, seed: int = 0) -> None:
        self._period = 1 / (SAMPLE_RATE * (1 + ppm * 1e-6))
        self._rng = np.random.default_rng(seed)
        self._jitter_s = jitter_s
        self.position = 0

    def block(self, late_s: float = 0.0) -> AudioBlock:
        times = (self.position + np.arange(BLOCK)) * self._period
        self.position += BLOCK
        late_s += float(self._rng.exponential(self._jitter_s)) if self._jitter_s else 0.0
        return AudioBlock(100 + times[0] + late_s, np.rint(8000 * np.sin(2 * np.pi * 200 * times)).astype(np.int16))


def phase_error(block: AudioBlock) -> float:
    """Return how late the tone in a block is, s, within half a period of 5 ms."""
    times = block.timestamp - 100 + np.arange(len(block.samples)) / SAMPLE_RATE
    phase = np.angle(np.sum(block.samples * np.exp(-2j * np.pi * 200 * times)))
    return float(-(phase + np.pi / 2) / (2 * np.pi * 200))


def run(card: Card, aligner: ClockAligner, seconds: float) -> list[AudioBlock]:
    return [aligner.align(card.block()) for _ in range(round(seconds * SAMPLE_RATE / BLOCK))]


@pytest.mark.slow
@pytest.mark.parametrize("ppm", [-300, -100, 0, 100, 300])
@pytest.mark.parametrize(("jitter_s", "dropout_s"), [(0.0, DROPOUT_S), (0.01, DROPOUT_S), (0.01, PLAYED_DROPOUT_S)])
def test_samples_stay_on_the_clock(ppm: float, jitter_s: float, dropout_s: float) -> None:
    blocks = run(Card(ppm, jitter_s=jitter_s), ClockAligner(dropout_s=dropout_s), 60)
    settled = blocks[len(blocks) // 3 :]
    errors = [abs(phase_error(block)) for block in settled]
    assert max(errors) < 0.0035 + jitter_s / 20  # of 5 ms allowed
    for before, after in pairwise(settled):
        assert after.timestamp == pytest.approx(before.end, abs=1e-6)
    sound = np.concatenate([block.samples for block in settled])
    assert pitch_hz(sound[-8000:]) == pytest.approx(200, rel=2e-3)
    assert max_jump(sound) < 1.02 * 2 * np.pi * 200 / SAMPLE_RATE * 8000 + 1


def test_a_true_clock_passes_samples_through() -> None:
    card, aligner = Card(0), ClockAligner()
    blocks = run(card, aligner, 1.0)
    assert [len(block.samples) for block in blocks] == [BLOCK] * len(blocks)
    assert max(abs(phase_error(block)) for block in blocks[1:]) < 1e-5


def test_a_late_first_block_is_corrected_at_once() -> None:
    card, aligner = Card(0), ClockAligner()
    blocks = [aligner.align(card.block(late_s=0.08)), *run(card, aligner, 1.0)]
    assert abs(phase_error(blocks[-1])) < 0.001
    assert blocks[-1].end == pytest.approx(100 + card.position / SAMPLE_RATE, abs=0.002)
    for before, after in pairwise(blocks):
        assert after.timestamp == pytest.approx(before.end, abs=1e-6)


def test_one_late_block_changes_nothing() -> None:
    card, aligner = Card(0), ClockAligner()
    run(card, aligner, 2.0)
    aligner.align(card.block(late_s=0.3))
    after = run(card, aligner, 2.0)
    assert max(abs(phase_error(block)) for block in after) < 1e-4


@pytest.mark.parametrize("dropout_s", [DROPOUT_S, PLAYED_DROPOUT_S])
@pytest.mark.parametrize("sooner_s", [0.001, 0.009, 0.02])
def test_sound_that_is_handed_on_sooner_keeps_its_rate(sooner_s: float, dropout_s: float) -> None:
    """A loudspeaker's echo would be one whose delay changes for seconds, which no filter follows."""
    card, aligner = Card(0), ClockAligner(dropout_s=dropout_s)
    before = [aligner.align(card.block(late_s=sooner_s)) for _ in range(150)]
    after = run(card, aligner, 3.0)
    assert {len(block.samples) for block in after} == {BLOCK}
    assert phase_error(after[-1]) == pytest.approx(phase_error(before[-1]), abs=1e-5)
    for a, b in pairwise([before[-1], *after]):
        assert b.timestamp == pytest.approx(a.end, abs=1e-6)


def test_a_microphone_whose_sound_is_handed_on_later_keeps_its_rate() -> None:
    card, aligner = Card(0), ClockAligner()
    before = run(card, aligner, 3.0)
    after = [aligner.align(card.block(late_s=0.009)) for _ in range(150)]
    assert {len(block.samples) for block in after} == {BLOCK}
    assert phase_error(after[-1]) == pytest.approx(phase_error(before[-1]), abs=1e-5)


def test_time_stamps_are_never_far_too_late() -> None:
    """Steps that are left out of account would add up."""
    card, aligner = Card(0), ClockAligner()
    for late_s in (0.06, 0.048, 0.036, 0.024, 0.012, 0.0):
        last = [aligner.align(card.block(late_s=late_s)) for _ in range(150)][-1]
    assert abs(last.end - 100 - card.position / SAMPLE_RATE) < 0.031


def test_a_loudspeaker_silent_for_a_millisecond_leaves_a_gap_soon() -> None:
    card, aligner = Card(0), ClockAligner(dropout_s=PLAYED_DROPOUT_S)
    before = run(card, aligner, 3.0)
    after = [aligner.align(card.block(late_s=0.001)) for _ in range(25)]
    gaps = [b.timestamp - a.end for a, b in pairwise([before[-1], *after])]
    assert sum(gaps) == pytest.approx(0.001, abs=1e-4) and max(gaps[:13]) == pytest.approx(sum(gaps), abs=1e-6)


def test_a_gap_that_was_none_is_taken_back() -> None:
    card, aligner = Card(0), ClockAligner(dropout_s=PLAYED_DROPOUT_S)
    run(card, aligner, 3.0)
    late = [aligner.align(card.block(late_s=0.02)) for _ in range(15)]
    assert max(b.timestamp - a.end for a, b in pairwise(late)) == pytest.approx(0.02, abs=1e-4)
    assert abs(phase_error(run(card, aligner, 1.0)[-1])) < 1e-4


@pytest.mark.slow
@pytest.mark.parametrize(("lost_s", "dropout_s"), [(0.2, DROPOUT_S), (0.2, PLAYED_DROPOUT_S), (0.01, PLAYED_DROPOUT_S)])
def test_a_dropout_leaves_a_gap_in_time_and_then_all_is_true_again(lost_s: float, dropout_s: float) -> None:
    card, aligner = Card(0), ClockAligner(dropout_s=dropout_s)
    before = run(card, aligner, 4.0)
    card.position += round(lost_s * SAMPLE_RATE)
    after = run(card, aligner, 5.0)
    assert after[-1].end == pytest.approx(100 + card.position / SAMPLE_RATE, abs=0.002)
    blocks = [before[-1], *after]
    gaps = [b.timestamp - a.end for a, b in pairwise(blocks)]
    assert max(gaps) == pytest.approx(lost_s, abs=0.002)
    assert sum(gap > 1e-6 for gap in gaps) == 1


def test_blocks_of_any_length() -> None:
    aligner, rng = ClockAligner(), np.random.default_rng(3)
    position = total = 0
    for count in [0, 1, 5, 4000, 0, *rng.integers(1, 700, 60)]:
        block = aligner.align(AudioBlock(position / SAMPLE_RATE, np.zeros(count, np.int16)))
        position, total = position + int(count), total + len(block.samples)
    assert total == pytest.approx(position, abs=2)
