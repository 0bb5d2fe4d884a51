"""The rate level falls quickly and rises slowly."""

import random
from itertools import pairwise

import pytest

from conf.protocol.feedback import Report, RoundTripEstimator
from conf.protocol.rate_control.congestion import (
    BACKOFF_WINDOW_S,
    LOSS_WINDOW_S,
    MAX_LOSS,
    MAX_RECOVER_S,
    RECOVER_S,
    SETTLE_S,
    CongestionControl,
    LossEstimator,
)
from conf.protocol.rate_control.rate_levels import RATE_LEVELS, RateLevel

RICH, LIVE, BUNDLED, NARROW = RATE_LEVELS
RATES = {RICH: 30, LIVE: 15, BUNDLED: 8, NARROW: 3}


class Link:
    """A sender under congestion control, a link with losses and delay, and a receiver that reports twice a second."""

    def __init__(self, *, top: int = 0, start: int = 1) -> None:
        self.now = 0.0
        self.control = CongestionControl(0.0, top=top, start=start)
        self.round_trip = RoundTripEstimator()
        self.highest = -1
        self.lost = 0
        self.random = random.Random(1)
        self.history: list[tuple[float, RateLevel]] = []

    def run(self, seconds: float, *, loss: float = 0.0, delay: float = 0.1) -> None:
        end = self.now + seconds
        while self.now < end:
            self.now += 0.5
            for _ in range(max(1, RATES[self.control.level] // 2)):
                self.highest += 1
                self.lost += self.random.random() < loss
            self.round_trip.on_sent(self.highest, self.now - delay)
            report = Report(self.highest, 0, min(self.lost, self.highest), 0, 0)
            self.round_trip.on_report(report, self.now)
            self.control.on_report(report, self.round_trip, self.now)
            if not self.history or self.history[-1][1] != self.control.level:
                self.history.append((self.now, self.control.level))


class Control:
    """Congestion control with exact reports: `expected` datagrams each half second, some lost, a fixed queue."""

    def __init__(self, *, start: int = 1) -> None:
        self.control = CongestionControl(0.0, start=start)
        self.now, self.highest, self.lost = 0.0, 0, 0

    def run(
        self, seconds: float, *, expected: int = 40, lost: int = 0, queue_s: float = 0.0, rtt_s: float = 0.1
    ) -> None:
        round_trip = estimator(rtt_s, queue_s)
        for _ in range(round(seconds * 2)):
            self.now += 0.5
            self.highest += expected
            self.lost += lost
            self.control.on_report(Report(self.highest, 0, self.lost, 0, 0), round_trip, self.now)


def estimator(rtt_s: float, queue_s: float) -> RoundTripEstimator:
    """Return an estimator with one shortest sample and a median of `queue_s` more."""
    round_trip = RoundTripEstimator()
    for counter, sample in enumerate([rtt_s] + [rtt_s + queue_s] * 5):
        round_trip.on_sent(counter, 0.0)
        round_trip.on_report(Report(counter, 0, 0, 0, 0), sample)
    return round_trip


def test_it_starts_live_and_a_good_link_reaches_rich_after_ten_seconds() -> None:
    link = Link()
    assert link.control.level == LIVE
    link.run(20)
    assert link.control.level == RICH
    assert link.history[1][0] == pytest.approx(RECOVER_S, abs=2.0)


def test_it_never_rises_above_the_top_and_starts_no_higher() -> None:
    assert CongestionControl(0.0, top=2).level == BUNDLED
    link = Link(top=1)
    link.run(100)
    assert link.control.level == LIVE


@pytest.mark.parametrize("loss", [0.12, 0.3, 1.0])
def test_loss_leads_down_to_narrow_and_stays_there(loss: float) -> None:
    link = Link()
    link.run(60, loss=loss)
    assert link.control.level == NARROW
    link.run(60, loss=loss)
    assert link.control.level == NARROW


def test_a_growing_queue_leads_down() -> None:
    link = Link()
    link.run(8)
    link.run(12, delay=0.5)
    assert link.control.level in (BUNDLED, NARROW)


def test_a_long_path_is_not_a_queue() -> None:
    link = Link()
    link.run(30, delay=2.0)
    assert link.control.level == RICH


def test_a_little_loss_does_not_lead_down() -> None:
    link = Link()
    link.run(120, loss=0.025)
    assert all(level in (RICH, LIVE) for _, level in link.history)


@pytest.mark.parametrize(
    ("rtt_s", "queue_s", "level"),
    [
        (0.1, 0.09, RICH),
        (0.1, 0.11, LIVE),  # more than half of the limit of 0.2 s
        (0.1, 0.19, LIVE),
        (0.1, 0.21, BUNDLED),
        (1.0, 0.24, RICH),  # on a long path the limit is half of the round trip
        (1.0, 0.26, LIVE),
        (1.0, 0.49, LIVE),
        (1.0, 0.51, BUNDLED),
    ],
)
def test_the_limits_of_the_queue(rtt_s: float, queue_s: float, level: RateLevel) -> None:
    control = Control()
    control.run(RECOVER_S if level is RICH else SETTLE_S, rtt_s=rtt_s, queue_s=queue_s)
    if level is LIVE:
        control.run(2 * RECOVER_S, rtt_s=rtt_s, queue_s=queue_s)
    assert control.control.level == level


@pytest.mark.parametrize(
    ("rtt_s", "queue_s", "is_high"),
    [(0.1, 0.149, False), (0.1, 0.151, True), (1.0, 0.374, False), (1.0, 0.376, True), (0.1, 0.0, False)],
)
def test_a_queue_is_high_above_three_quarters_of_its_limit(rtt_s: float, queue_s: float, is_high: bool) -> None:
    assert CongestionControl(0.0).queue_is_high(estimator(rtt_s, queue_s)) == is_high


def test_a_queue_is_not_high_before_the_first_report() -> None:
    assert not CongestionControl(0.0).queue_is_high(RoundTripEstimator())


def test_loss_between_two_and_five_per_cent_holds_the_level() -> None:
    control = Control()
    control.run(40, expected=40, lost=1)
    assert control.control.level == LIVE
    control.run(10, expected=100, lost=1)
    control.run(RECOVER_S, expected=100, lost=1)
    assert control.control.level == RICH


def test_levels_change_at_most_every_three_seconds_and_recover_by_themselves() -> None:
    link = Link()
    link.run(30, loss=0.3)
    times = [time for time, _ in link.history[1:]]
    assert all(later - earlier >= SETTLE_S for earlier, later in pairwise(times))
    link.run(120)
    assert link.control.level == RICH


def test_the_first_step_down_waits_until_the_link_has_settled() -> None:
    control = Control()
    control.run(SETTLE_S - 0.5, lost=20)
    assert control.control.level == LIVE
    control.run(0.5, lost=20)
    assert control.control.level == BUNDLED
    control.run(SETTLE_S - 0.5, lost=20)
    assert control.control.level == BUNDLED
    control.run(0.5, lost=20)
    assert control.control.level == NARROW


def test_a_level_that_fails_again_and_again_is_tried_less_and_less_often() -> None:
    link = Link()
    for _ in range(1600):
        link.run(0.5, loss=0.3 if link.control.level == RICH else 0.0)
    raised = [time for time, level in link.history if level == RICH]
    gaps = [later - earlier for earlier, later in pairwise(raised)]
    assert gaps[0] < gaps[1] < gaps[2]
    assert max(gaps) <= MAX_RECOVER_S + 20


def test_only_a_step_up_that_soon_fails_doubles_the_time_to_the_next() -> None:
    for good_s, recover_s in ((BACKOFF_WINDOW_S - 2, 2 * RECOVER_S), (BACKOFF_WINDOW_S + 2, RECOVER_S)):
        control = Control()
        control.run(RECOVER_S)
        assert control.control.level == RICH
        control.run(good_s)
        while control.control.level == RICH:
            control.run(0.5, lost=40)
        control.run(recover_s - 0.5)
        assert control.control.level == LIVE
        control.run(0.5)
        assert control.control.level == RICH


def test_a_still_face_tells_nothing_about_the_link() -> None:
    """One keep-alive a second, one of them lost, is no loss of 50 %."""
    control, round_trip = CongestionControl(0.0), RoundTripEstimator()
    for second in range(30):
        control.on_report(Report(second, 0, min(second, 1), 0, 0), round_trip, float(second))
    assert control.level == LIVE


def loss(*totals: tuple[float, int, int]) -> LossEstimator:
    estimator = LossEstimator()
    for now, highest, lost in totals:
        estimator.on_report(Report(highest, 0, lost, 0, 0), now)
    return estimator


def test_loss_is_measured_over_the_window() -> None:
    assert (loss().expected, loss().fraction, loss().is_significant) == (0, 0.0, False)
    assert loss((0.0, 100, 50)).fraction == 0.0
    half = loss((0.0, 100, 0), (5.0, 200, 50))
    assert (half.expected, half.fraction) == (100, 0.5)
    old = loss((0.0, 100, 0), (1.0, 200, 50), (1.0 + LOSS_WINDOW_S - 0.1, 300, 50))
    assert old.fraction == 0.25
    old = loss((0.0, 100, 0), (1.0, 200, 50), (1.0 + LOSS_WINDOW_S, 300, 50))
    assert (old.expected, old.fraction) == (100, 0.0)


def test_old_totals_are_kept_while_there_are_too_few_new_ones() -> None:
    few = loss((0.0, 0, 0), (1.0, 100, 50), (100.0, 119, 50))
    assert few.expected == 119
    enough = loss((0.0, 0, 0), (1.0, 100, 50), (100.0, 120, 50))
    assert enough.expected == 20


def test_a_report_out_of_order_is_ignored_and_late_arrivals_are_no_negative_loss() -> None:
    estimator = loss((0.0, 100, 10), (1.0, 200, 30), (2.0, 150, 90))
    assert (estimator.expected, estimator.fraction) == (100, 0.2)
    assert loss((0.0, 100, 10), (1.0, 200, 5)).fraction == 0.0


def test_a_restart_keeps_the_newest_totals() -> None:
    estimator = loss((0.0, 100, 10), (1.0, 200, 60))
    estimator.restart()
    assert (estimator.expected, estimator.fraction) == (0, 0.0)
    estimator.on_report(Report(300, 0, 70, 0, 0), 2.0)
    assert (estimator.expected, estimator.fraction) == (100, 0.1)


@pytest.mark.parametrize(
    ("expected", "lost", "is_heavy"),
    [
        (100, 9, False),
        (100, 10, True),
        (1000, 64, False),
        (1000, 65, True),
        (20, 3, False),
        (20, 4, True),
        (19, 19, False),
    ],
)
def test_loss_is_heavy_if_it_exceeds_5_percent_by_two_standard_deviations(
    expected: int, lost: int, is_heavy: bool
) -> None:
    assert loss((0.0, 50, 0), (1.0, 50 + expected, lost)).exceeds(MAX_LOSS) == is_heavy
