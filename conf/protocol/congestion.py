"""How fast the sender may go: a ladder of profiles, a circuit breaker, a cap in kbit/s. Time is an argument.

Strategy. Quickly down, slowly up. More than 5 % loss over the last seconds, or a queue that grows, is a step down the
ladder; then the link gets time to show the effect. Ten calm seconds are a step up; each step up that had to be taken
back soon doubles that time. Without any report for ten seconds nothing is sent but a small probe now and then, until a
report comes.
Source: RFC 8083 (circuit breaker); RFC 8085, 3.1 (datagram congestion control).
"""

import math
from collections import deque
from dataclasses import dataclass

from conf.protocol.feedback import Report, RoundTripEstimator


@dataclass(frozen=True)
class RateLevel:
    """A step of the ladder: a profile, and how many times its usual number of frames share a datagram."""

    profile: str
    bundling: int = 1


RATE_LEVELS = (RateLevel("rich"), RateLevel("live"), RateLevel("live", 2), RateLevel("narrow"))

MAX_LOSS = 0.05
LOW_LOSS = 0.02
MAX_QUEUEING_S = 0.2
CROWDED = 0.75  # of that limit
LOSS_WINDOW_S = 10.0
MIN_EXPECTED = 20  # fewer datagrams than this say nothing about five per cent
SETTLE_S = 3.0
RECOVER_S = 10.0
MAX_RECOVER_S = 160.0
BACKOFF_WINDOW_S = 20.0


class LossMeter:
    """The fraction of datagrams lost over the last seconds, from the reports' totals."""

    def __init__(self) -> None:
        self._totals: deque[tuple[float, int, int]] = deque()

    def reported(self, report: Report, now: float) -> None:
        """Take a report; one that comes late, out of order, is ignored."""
        if self._totals and report.highest < self._totals[-1][1]:
            return
        self._totals.append((now, report.highest, report.lost))
        while len(self._totals) > 2 and self._totals[1][0] <= now - LOSS_WINDOW_S and self._enough_without_oldest():
            self._totals.popleft()

    def restart(self) -> None:
        """Forget all but the newest totals."""
        while len(self._totals) > 1:
            self._totals.popleft()

    @property
    def expected(self) -> int:
        """How many datagrams the figure rests on."""
        return self._totals[-1][1] - self._totals[0][1] if self._totals else 0

    @property
    def heavy(self) -> bool:
        """Whether the loss is above 5 % by more than chance: by two standard deviations of what 5 % loses."""
        allowed = MAX_LOSS * self.expected
        return self.enough and self.fraction * self.expected > allowed + 2 * math.sqrt(allowed)

    @property
    def enough(self) -> bool:
        """Whether the figure rests on enough datagrams to mean something."""
        return self.expected >= MIN_EXPECTED

    @property
    def fraction(self) -> float:
        """Lost out of expected, 0 to 1."""
        if not self.expected:
            return 0.0
        return max(0, self._totals[-1][2] - self._totals[0][2]) / self.expected

    def _enough_without_oldest(self) -> bool:
        return self._totals[-1][1] - self._totals[1][1] >= MIN_EXPECTED


class CongestionControl:
    """The rung of the ladder to send at.

    top : the highest rung allowed, an index into LADDER
    """

    def __init__(self, now: float, *, top: int = 0, start: int = 1) -> None:
        self.loss = LossMeter()
        self._top = top
        self._index = max(top, start)
        self._changed = now
        self._calm_since = now
        self._recover_s = RECOVER_S
        self._raised_at: float | None = None

    @property
    def rung(self) -> RateLevel:
        """The present rung."""
        return RATE_LEVELS[self._index]

    def reported(self, report: Report, round_trip: RoundTripEstimator, now: float) -> None:
        """Take a report, after `round_trip` has taken it; `rung` may have changed afterwards."""
        self.loss.reported(report, now)
        if now < self._changed + SETTLE_S:
            return
        queueing, queueing_limit = round_trip.queueing_s, _queueing_limit(round_trip)
        if self.loss.heavy or queueing > queueing_limit:
            self._calm_since = now
            self._step_down(now)
        elif self.loss.fraction > LOW_LOSS or queueing > queueing_limit / 2 or not self.loss.enough:
            self._calm_since = now
        elif now >= self._calm_since + self._recover_s:
            self._step_up(now)

    def queue_is_high(self, round_trip: RoundTripEstimator) -> bool:
        """Whether queues are near the limit: what can wait should, before the motion has to go a step down."""
        return round_trip.queueing_s > CROWDED * _queueing_limit(round_trip)

    def _step_down(self, now: float) -> None:
        if self._raised_at is not None:
            soon = now < self._raised_at + BACKOFF_WINDOW_S
            self._recover_s = min(2 * self._recover_s, MAX_RECOVER_S) if soon else RECOVER_S
            self._raised_at = None
        self._move(min(self._index + 1, len(RATE_LEVELS) - 1), now)

    def _step_up(self, now: float) -> None:
        if self._index > self._top:
            self._raised_at = now
            self._move(self._index - 1, now)

    def _move(self, index: int, now: float) -> None:
        if index != self._index:
            self._index = index
            self._changed = self._calm_since = now
            self.loss.restart()


def _queueing_limit(round_trip: RoundTripEstimator) -> float:
    return max(MAX_QUEUEING_S, (round_trip.min_rtt_s or 0.0) / 2)
