"""The rate level falls quickly and rises slowly."""

import random
from itertools import pairwise

import pytest

from conf.protocol.congestion import (
    MAX_RECOVER_S,
    RATE_LEVELS,
    SETTLE_S,
    CongestionControl,
    RateLevel,
)
from conf.protocol.feedback import Report, RoundTripEstimator

RICH, LIVE, BUNDLED, NARROW = RATE_LEVELS
RATES = {RICH: 30, LIVE: 15, BUNDLED: 8, NARROW: 3}


class Link:
    """A sender with a control, a link that loses and delays, and a receiver that reports twice a second."""

    def __init__(self, **options: int) -> None:
        self.now = 0.0
        self.control = CongestionControl(0.0, **options)
        self.trip = RoundTripEstimator()
        self.highest = -1
        self.lost = 0
        self.random = random.Random(1)
        self.history: list[tuple[float, RateLevel]] = []

    def run(self, seconds: float, *, loss: float = 0.0, delay: float = 0.1) -> None:
        end = self.now + seconds
        while self.now < end:
            self.now += 0.5
            for _ in range(max(1, RATES[self.control.rung] // 2)):
                self.highest += 1
                self.lost += self.random.random() < loss
            self.trip.sent(self.highest, self.now - delay)
            report = Report(self.highest, 0, min(self.lost, self.highest), 0, 0)
            self.trip.on_report(report, self.now)
            self.control.reported(report, self.trip, self.now)
            if not self.history or self.history[-1][1] != self.control.rung:
                self.history.append((self.now, self.control.rung))


def test_it_starts_live_and_a_good_link_reaches_rich() -> None:
    link = Link()
    assert link.control.rung == LIVE
    link.run(20)
    assert link.control.rung == RICH


def test_it_never_climbs_above_the_top() -> None:
    link = Link(top=1)
    link.run(100)
    assert link.control.rung == LIVE


@pytest.mark.parametrize("loss", [0.12, 0.3, 1.0])
def test_loss_leads_down_to_narrow_and_stays_there(loss: float) -> None:
    link = Link()
    link.run(60, loss=loss)
    assert link.control.rung == NARROW
    link.run(60, loss=loss)
    assert link.control.rung == NARROW


def test_a_growing_queue_leads_down() -> None:
    link = Link()
    link.run(8)
    link.run(12, delay=0.5)
    assert link.control.rung in (BUNDLED, NARROW)


def test_a_long_way_is_not_a_queue() -> None:
    link = Link()
    link.run(30, delay=2.0)
    assert link.control.rung == RICH


def test_a_little_loss_does_not_lead_down() -> None:
    link = Link()
    link.run(120, loss=0.025)
    assert all(rung in (RICH, LIVE) for _, rung in link.history)


def test_steps_are_apart_and_recovery_comes_by_itself() -> None:
    link = Link()
    link.run(30, loss=0.3)
    times = [time for time, _ in link.history[1:]]
    assert all(later - earlier >= SETTLE_S for earlier, later in pairwise(times))
    link.run(120)
    assert link.control.rung == RICH


def test_a_rung_that_fails_again_and_again_is_tried_less_and_less_often() -> None:
    link = Link()
    for _ in range(1600):
        link.run(0.5, loss=0.3 if link.control.rung == RICH else 0.0)
    climbs = [time for time, rung in link.history if rung == RICH]
    gaps = [later - earlier for earlier, later in pairwise(climbs)]
    assert gaps[0] < gaps[1] < gaps[2]
    assert max(gaps) <= MAX_RECOVER_S + 20


def test_a_still_face_says_nothing_about_the_link() -> None:
    """One keep-alive a second, one of them lost: that is no 50 % of anything."""
    control, trip = CongestionControl(0.0), RoundTripEstimator()
    for second in range(30):
        control.reported(Report(second, 0, min(second, 1), 0, 0), trip, float(second))
    assert control.rung == LIVE
