"""When packets are repeated: soon after the first loss, and for some time after the last."""

import random

import pytest

from conf.protocol.feedback import Report
from conf.protocol.rate_control.rate_levels import LossyVoice
from conf.protocol.rate_control.repetition import LONG_WINDOW_S, Repetition
from conf.protocol.voice.formats import VoiceFormat

FORMAT = VoiceFormat("codec2", 1200, 40, 6, fixed_size=True, repeated=6)


def stages(*losses: float) -> list[LossyVoice]:
    return [LossyVoice(loss, FORMAT) for loss in losses]


class Link:
    """Reports twice a second of a link with `rate` datagrams a second."""

    def __init__(self, rate: int, threshold: float) -> None:
        self.repetition = Repetition()
        self._rate, self._threshold = rate, threshold
        self._sent = self._lost = 0
        self.now = 0.0

    def run(self, seconds: float, lost: int = 0) -> float:
        """Report, `lost` lost at first. Returns for how many of the seconds packets were repeated."""
        repeated = 0.0
        for step in range(round(2 * seconds)):
            self.now += 0.5
            self._sent += self._rate // 2
            self._lost += lost if not step else 0
            self.repetition.on_report(Report(self._sent, 0, self._lost, 0, 0), stages(self._threshold), self.now)
            repeated += 0.5 * self.repetition.stage
        return repeated


@pytest.mark.parametrize(("rate", "clean_s"), [(4, 0.5), (4, 1.5), (6, 0.5), (6, 1.0)])
def test_one_lost_packet_of_the_first_ten_begins_the_repetition_at_once(rate: int, clean_s: float) -> None:
    link = Link(rate, 0.07)
    assert link.run(clean_s) == 0
    assert link.run(0.5, lost=1) == 0.5


def test_later_two_lost_packets_begin_it() -> None:
    link = Link(4, 0.04)
    assert link.run(20) == 0 and link.run(1, lost=1) == 0
    assert link.run(0.5, lost=1) == 0.5


def test_it_ends_when_the_long_window_holds_no_loss() -> None:
    link = Link(4, 0.04)
    link.run(1)
    assert link.run(40, lost=2) == pytest.approx(LONG_WINDOW_S, abs=1.0)


@pytest.mark.parametrize(
    ("loss", "rate", "threshold", "least", "most"),
    [(0.1, 4, 0.04, 0.97, 1.0), (0.06, 8, 0.04, 0.95, 1.0), (0.005, 8, 0.04, 0.0, 0.1), (0.01, 4, 0.05, 0.0, 0.3)],
)
def test_how_much_of_a_call_is_repeated_at_a_steady_loss(
    loss: float, rate: int, threshold: float, least: float, most: float
) -> None:
    rng, link, repeated = random.Random(3), Link(rate, threshold), 0.0
    for _ in range(1200):
        repeated += link.run(0.5, lost=sum(rng.random() < loss for _ in range(rate // 2)))
    assert least <= repeated / 600 <= most


def test_a_heavier_loss_has_a_stage_of_its_own_for_which_more_must_be_known() -> None:
    repetition, reached = Repetition(), []
    for step, lost in enumerate((0, 2, 4, 8, 16, 24, 26, 28, 28, 28)):
        repetition.on_report(Report(10 * (step + 1), 0, lost, 0, 0), stages(0.07, 0.16), 2.5 * step)
        reached.append(repetition.stage)
    assert reached == [0, 1, 1, 1, 2, 2, 2, 2, 2, 2]
    for step in range(10, 20):
        repetition.on_report(Report(10 * (step + 1), 0, 28, 0, 0), stages(0.07, 0.16), 2.5 * step)
        reached.append(repetition.stage)
    assert reached[10:] == sorted(reached[10:], reverse=True) and reached[-1] == 0


def test_another_level_may_have_fewer_stages() -> None:
    repetition = Repetition()
    for step in range(6):
        repetition.on_report(Report(20 * (step + 1), 0, 8 * step, 0, 0), stages(0.07, 0.16), 2.0 * step)
    assert repetition.stage == 2
    repetition.on_report(Report(121, 0, 40, 0, 0), stages(0.07), 12.0)
    assert repetition.stage == 1
    repetition.on_report(Report(122, 0, 40, 0, 0), (), 12.5)
    assert repetition.stage == 0


@pytest.mark.parametrize(("missing", "stage"), [(0b0100100010000, 1), (0b0110100010000, 1), (0b0111000111000, 0)])
def test_losses_in_bursts_are_not_repeated(missing: int, stage: int) -> None:
    repetition = Repetition()
    repetition.on_report(Report(1, 0, 0, 0, 0), stages(0.07), 0.0)
    repetition.on_report(Report(20, missing, missing.bit_count(), 0, 0), stages(0.07), 5.0)
    assert repetition.stage == stage
    repetition.on_report(Report(40, 1, missing.bit_count() + 1, 0, 0), stages(0.07), 6.0)  # one tells nothing
    assert repetition.stage == stage
    repetition.on_report(Report(60, 0b10010010, missing.bit_count() + 4, 0, 0), stages(0.07), 7.0)
    assert repetition.stage == 1


def test_a_stage_that_bursts_cannot_spoil_is_used_in_them() -> None:
    repetition = Repetition()
    for highest, missing, lost in ((1, 0, 0), (20, 0b111, 3)):
        repetition.on_report(Report(highest, missing, lost, 0, 0), [LossyVoice(0.07, FORMAT, in_bursts=True)], 5.0)
    assert repetition.stage == 1
