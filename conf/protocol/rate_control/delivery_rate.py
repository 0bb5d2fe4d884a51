"""The rate at which the link delivers, from reports. Time is an argument.

Strategy. A report tells which datagrams have arrived, and when the newest did. Their bytes, over the time between the
arrivals that two reports name, are the rate; where a queue grows it is what the link can carry. A queue grows when
arrivals are further apart than the datagrams were sent.
Source: Cardwell, Cheng, Gunn, Yeganeh, Jacobson 2016 (BBR, delivery rate).
"""

from collections import OrderedDict, deque
from dataclasses import dataclass

from conf.protocol.feedback import MILLISECOND, Report

WINDOW_S = 2.0  # between the oldest and the newest arrival that are compared
MIN_SPAN_S = 0.4  # two reports
MAX_REMEMBERED = 512  # datagrams
GROWTH = 0.8  # of the time between arrivals: less between the datagrams when they were sent is a queue that grows


@dataclass(frozen=True)
class _Arrival:
    """Of the newest datagram that a report names. wire_bytes : of all that arrived since the report before"""

    arrived_at: float
    sent_at: float
    wire_bytes: int


class DeliveryRate:
    """The delivery rate of one sender's datagrams.

    kbps : kbit/s over the last seconds, headers included; None if reports tell too little
    is_backing_up : whether a queue grew meanwhile
    newest_sent_at : when the newest datagram that has arrived was sent, None before a report
    """

    def __init__(self) -> None:
        self.kbps: float | None = None
        self.is_backing_up = False
        self.newest_sent_at: float | None = None
        self._sent: OrderedDict[int, tuple[float, int]] = OrderedDict()  # time and bytes by counter
        self._arrivals: deque[_Arrival] = deque()

    def on_sent(self, counter: int, wire_bytes: int, now: float) -> None:
        """Record a datagram. wire_bytes : its size, headers included"""
        self._sent[counter] = now, wire_bytes
        if len(self._sent) > MAX_REMEMBERED:
            self._sent.popitem(last=False)

    def on_report(self, report: Report, now: float) -> None:
        """Apply a report; one that names no newer datagram is ignored."""
        if report.highest not in self._sent:
            return
        self.newest_sent_at = sent_at = self._sent[report.highest][0]
        arrived = sum(self._sent[counter][1] for counter in report.acknowledged() if counter in self._sent)
        while self._sent and next(iter(self._sent)) <= report.highest:
            self._sent.popitem(last=False)
        self._arrivals.append(_Arrival(now - report.ack_delay_ms * MILLISECOND, sent_at, arrived))
        while self._arrivals[-1].arrived_at - self._arrivals[0].arrived_at > WINDOW_S and len(self._arrivals) > 2:
            self._arrivals.popleft()
        self._update()

    def restart(self) -> None:
        """Measure from the newest arrival on: the sender has changed its rate."""
        while len(self._arrivals) > 1:
            self._arrivals.popleft()
        self.kbps, self.is_backing_up = None, False

    @property
    def backlog_s(self) -> float:
        """Seconds that the link needs for the datagrams of which no report tells yet; 0 if its rate is not known."""
        waiting = sum(size for _, size in self._sent.values())
        return waiting * 8 / 1000 / self.kbps if self.kbps else 0.0

    def _update(self) -> None:
        oldest, newest = self._arrivals[0], self._arrivals[-1]
        span = newest.arrived_at - oldest.arrived_at
        self.kbps, self.is_backing_up = None, False
        if span >= MIN_SPAN_S:
            size = sum(arrival.wire_bytes for arrival in self._arrivals) - oldest.wire_bytes
            self.kbps = size * 8 / 1000 / span
            self.is_backing_up = newest.sent_at - oldest.sent_at < GROWTH * span
