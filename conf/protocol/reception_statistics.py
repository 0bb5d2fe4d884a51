"""Reception statistics of one session: datagrams received and lost, their jitter, and the reports made of them.

A datagram is lost if its counter is below the newest and it has not arrived. Source: RFC 3550, 6.4.1 (cumulative number
of packets lost) and A.3.
"""

from conf.protocol.feedback import MAX_MILLISECONDS, MILLISECOND, Report
from conf.protocol.session.replay_window import WINDOW, ReplayWindow
from conf.protocol.statistics import InterarrivalJitter

REPORT_INTERVAL_S = 0.5


class ReceptionStatistics:
    """Record the datagrams of one session and make reports of them.

    quiet : datagrams since the last report that called for none
    """

    def __init__(self) -> None:
        self.jitter = InterarrivalJitter()
        self._window = ReplayWindow()
        self._count = 0
        self._newest = -1
        self._highest_received_at = 0.0
        self._reported_at = float("-inf")
        self._is_called_for = False
        self.quiet = 0

    def add(
        self,
        counter: int,
        now: float,
        *,
        timestamp: float | None = None,
        decodable: bool = True,
        calls_for_report: bool = True,
    ) -> None:
        """Record an authenticated datagram.

        timestamp : of its newest frame, seconds on the sender's clock
        decodable : whether its body could be used; one that could not is neither lost nor acknowledged
        calls_for_report : whether it carried more than reports and acknowledgements
        """
        self._is_called_for |= calls_for_report
        self.quiet += not calls_for_report
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

    def report_due(self, now: float, *, interval_s: float = REPORT_INTERVAL_S) -> bool:
        """Return whether a report should be sent: some time after the last one, if something new called for it."""
        is_time = now >= self._reported_at + interval_s
        return self._is_called_for and is_time and self._window.highest >= 0

    def on_reported(self, now: float) -> None:
        """Record that a report has been sent."""
        self._reported_at = now
        self._is_called_for, self.quiet = False, 0

    def report(self, now: float) -> Report | None:
        """Return a report, None before the first datagram that could be used."""
        highest = self._window.highest
        if highest < 0:
            return None
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
