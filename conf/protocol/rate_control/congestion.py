"""Congestion control: the rate level to send at, from the receiver's reports. Time is an argument.

Strategy. Down quickly, up slowly. More than 5 % loss over the last seconds or a queue is one level down, after which
the link gets 3 s to show the effect. A queue that grows tells what the link can carry: at once down to the level that
fits it. Ten good seconds are one level up. Each level up that soon had to be taken back doubles that time. With voice,
loss alone leads down only from 25 %: below that, repetition helps more than a lower rate does, and a link that is too
slow shows a queue.
Source: RFC 8085, 3.1 (congestion control of datagrams).
"""

import math
from collections import deque
from collections.abc import Sequence

from conf.protocol.feedback import Report, RoundTripEstimator
from conf.protocol.rate_control.delivery_rate import DeliveryRate
from conf.protocol.rate_control.rate_levels import RATE_LEVELS, RateLevel

MAX_LOSS = 0.05
MAX_VOICE_LOSS = 0.25
LOW_LOSS_FRACTION = 0.4  # of the loss that leads down: below it the level may rise
MAX_QUEUEING_S = 0.2
HIGH_QUEUE_FRACTION = 0.75  # of the queueing limit
LOSS_WINDOW_S = 10.0
MIN_EXPECTED = 20  # fewer datagrams cannot tell 5 % from chance
SETTLE_S = 3.0
RECOVER_S = 10.0
MAX_RECOVER_S = 160.0
BACKOFF_WINDOW_S = 20.0


class LossEstimator:
    """The fraction of datagrams lost over the last seconds, from the totals in the reports."""

    def __init__(self, window_s: float = LOSS_WINDOW_S) -> None:
        self._window_s = window_s
        self._totals: deque[tuple[float, int, int]] = deque()  # time, highest counter, lost

    def on_report(self, report: Report, now: float) -> None:
        """Apply a report; one that arrives out of order is ignored."""
        if self._totals and report.highest < self._totals[-1][1]:
            return
        self._totals.append((now, report.highest, report.lost))
        while len(self._totals) > 2:
            time, highest, _ = self._totals[1]
            if time > now - self._window_s or report.highest - highest < MIN_EXPECTED:
                break
            self._totals.popleft()

    def reset(self) -> None:
        """Drop all totals: the counters of a new session begin at 0."""
        self._totals.clear()

    def restart(self) -> None:
        """Drop all but the newest totals."""
        while len(self._totals) > 1:
            self._totals.popleft()

    @property
    def expected(self) -> int:
        """Number of datagrams that the fraction is measured on."""
        return self._totals[-1][1] - self._totals[0][1] if self._totals else 0

    def exceeds(self, fraction: float) -> bool:
        """Return whether the loss exceeds a fraction by two standard deviations of what such a loss would show."""
        allowed = fraction * self.expected
        return self.is_significant and self.fraction * self.expected > allowed + 2 * math.sqrt(allowed)

    @property
    def is_significant(self) -> bool:
        """Whether the fraction is measured on enough datagrams."""
        return self.expected >= MIN_EXPECTED

    @property
    def fraction(self) -> float:
        """Lost out of expected, 0 to 1."""
        if not self.expected:
            return 0.0
        return max(0, self._totals[-1][2] - self._totals[0][2]) / self.expected


class CongestionControl:
    """Choose the rate level.

    levels : to choose from; top, start : the highest level allowed and the first, indices into `levels`
    max_loss : the fraction above which the level falls
    """

    def __init__(
        self,
        now: float,
        *,
        top: int = 0,
        start: int = 1,
        levels: Sequence[RateLevel] = RATE_LEVELS,
        max_loss: float = MAX_LOSS,
    ) -> None:
        self.loss = LossEstimator()
        self._levels = levels
        self._max_loss = max_loss
        self._top = top
        self._index = max(top, start)
        self._changed_at = now
        self._settled_at = now + SETTLE_S
        self._good_since = now
        self._recover_s = RECOVER_S
        self._raised_at: float | None = None

    @property
    def level(self) -> RateLevel:
        """The level to send at."""
        return self._levels[self._index]

    def on_report(
        self, report: Report, round_trip: RoundTripEstimator, now: float, *, delivery: DeliveryRate | None = None
    ) -> None:
        """Apply a report after `round_trip` and `delivery` have; `level` may change."""
        self.loss.on_report(report, now)
        if delivery and delivery.newest_sent_at is not None and delivery.newest_sent_at < self._changed_at:
            self._settled_at = max(self._settled_at, now + SETTLE_S)  # what arrives was sent before the last change
            return
        queueing, queueing_limit = round_trip.queueing_s, _queueing_limit(round_trip)
        if delivery and delivery.is_backing_up and round_trip.newest_queueing_s > queueing_limit:
            self._good_since = now
            self._step_down(now, delivery.kbps)
            return
        if now < self._settled_at:
            return
        if self.loss.exceeds(self._max_loss) or queueing > queueing_limit:
            self._good_since = now
            self._step_down(now)
        elif (
            self.loss.fraction > self._max_loss * LOW_LOSS_FRACTION
            or queueing > queueing_limit / 2
            or not self.loss.is_significant
        ):
            self._good_since = now
        elif now >= self._good_since + self._recover_s:
            self._step_up(now)

    def queue_is_high(self, round_trip: RoundTripEstimator) -> bool:
        """Return whether the queue is near its limit: data that can wait should, before the motion loses a level."""
        return round_trip.queueing_s > HIGH_QUEUE_FRACTION * _queueing_limit(round_trip)

    def _step_down(self, now: float, kbps: float | None = None) -> None:
        """Go down a level, or to the highest below it that fits `kbps`."""
        if self._raised_at is not None:
            is_soon = now < self._raised_at + BACKOFF_WINDOW_S
            self._recover_s = min(2 * self._recover_s, MAX_RECOVER_S) if is_soon else RECOVER_S
            self._raised_at = None
        index = min(self._index + 1, len(self._levels) - 1)
        while kbps is not None and index < len(self._levels) - 1 and self._levels[index].kbps > kbps:
            index += 1
        self._move(index, now)

    def _step_up(self, now: float) -> None:
        if self._index > self._top:
            self._raised_at = now
            self._move(self._index - 1, now)

    def _move(self, index: int, now: float) -> None:
        if index != self._index:
            self._index = index
            self._changed_at = self._good_since = now
            self._settled_at = now + SETTLE_S
            self.loss.restart()


def _queueing_limit(round_trip: RoundTripEstimator) -> float:
    return max(MAX_QUEUEING_S, (round_trip.min_rtt_s or 0.0) / 2)
