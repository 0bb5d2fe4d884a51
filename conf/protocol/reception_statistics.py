"""Reception statistics of one session: datagrams received and lost, their jitter, and the reports made of them.

A datagram is lost if its counter is below the newest and it has not arrived. Source: RFC 3550, 6.4.1 (cumulative number
of packets lost) and A.3.
"""

from conf.protocol.feedback import MAX_MILLISECONDS, MILLISECOND, Report
from conf.protocol.session.replay_window import WINDOW, ReplayWindow
from conf.protocol.statistics import InterarrivalJitter

REPORT_INTERVAL_S = 0.5


class ReceptionStatistics:
    """Record the datagrams of one session and make reports of them."""

    def __init__(self) -> None:
        self.jitter = InterarrivalJitter()
        self._window = ReplayWindow()
        self._count = 0
        self._newest = -1
        self._highest_received_at = 0.0
        self._due = float("-inf")

    def add(self, counter: int, now: float, *, timestamp: float | None = None, decodable: bool = True) -> None:
        """Record an authenticated datagram.

        timestamp : of its newest frame, seconds on the sender's clock
        decodable : whether its body could be used; one that could not is neither lost nor acknowledged
        """
        self._count += 1
        self._newest = max(self._newest, counter)
        if not decodable:
            return
        if counter > self._window.highest:
            self._highest_received_at = now
        self._window.accept(counter)
        if timestamp is not None:
            self.jitter.add(timestamp, now)

    @property
    def lost(self) -> int:
        """Datagrams lost since the start."""
        return self._newest + 1 - self._count

    def report(self, now: float) -> Report | None:
        """Return a report if one is due: every half second after the first datagram."""
        highest = self._window.highest
        if now < self._due or highest < 0:
            return None
        self._due = now + REPORT_INTERVAL_S
        covered = min(highest, WINDOW - 1)
        return Report(
            highest=highest,
            missing=~(self._window.received >> 1) & ((1 << covered) - 1),
            lost=min(self.lost, highest),
            jitter_ms=_milliseconds(self.jitter.seconds),
            ack_delay_ms=_milliseconds(now - self._highest_received_at),
        )


def _milliseconds(seconds: float) -> int:
    return min(MAX_MILLISECONDS, max(0, round(seconds / MILLISECOND)))
