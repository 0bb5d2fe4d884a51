"""Reception reports, twice a second from receiver to sender, and the round trip time estimated from them.

Strategy. A report names the highest counter received and how long ago that was. The counter is the echo: the sender
knows when it sent it, so that no datagram carries a time. Losses are counted since the start, so that a lost report
loses nothing; `reception_statistics` counts them. The report lists missing counters instead of received ones, as they
are fewer.
Source: RFC 3550, 6.4 (reports, round trip); RFC 6298 (smoothing).
"""

from collections import OrderedDict, deque
from dataclasses import astuple, dataclass

import msgpack

from conf.errors import ProtocolError
from conf.protocol.session.replay_window import WINDOW

MILLISECOND = 1e-3
MAX_MILLISECONDS = 0xFFFF
# The largest value of each field on the wire.
_LIMITS = (0xFFFFFFFF, (1 << WINDOW - 1) - 1, 0xFFFFFFFF, MAX_MILLISECONDS, MAX_MILLISECONDS)
MAX_REPORT_BYTES = 32
_ARRAY_OF_FIVE = b"\x95"  # which a report does not need to send


@dataclass(frozen=True)
class Report:
    """What the receiver has received of the sender's datagrams.

    highest : the highest counter received
    missing : bit i is set if counter highest - 1 - i has not been received, for the 63 before the highest
    lost : datagrams lost since the start
    jitter_ms : interarrival jitter
    ack_delay_ms : time since the highest was received
    """

    highest: int
    missing: int
    lost: int
    jitter_ms: int
    ack_delay_ms: int

    def acknowledged(self) -> list[int]:
        """Return the counters that the report confirms as received, newest first."""
        before = range(min(self.highest, WINDOW - 1))
        return [self.highest, *(self.highest - 1 - i for i in before if not self.missing >> i & 1)]


def encode_report(report: Report) -> bytes:
    """Return a report's bytes: five msgpack integers, usually 7 B."""
    data: bytes = msgpack.packb(astuple(report))
    return data[len(_ARRAY_OF_FIVE) :]


def decode_report(data: bytes) -> Report:
    """Return the report. Raises ProtocolError, whatever the bytes, and no other exception."""
    if len(data) > MAX_REPORT_BYTES:
        raise ProtocolError("a report is too long")
    try:
        fields = msgpack.unpackb(
            _ARRAY_OF_FIVE + data, max_array_len=5, max_map_len=0, max_ext_len=0, max_str_len=0, max_bin_len=0
        )
    except (ValueError, msgpack.UnpackException) as error:
        raise ProtocolError("a report is not five msgpack integers") from error
    if any(type(n) is not int or not 0 <= n <= limit for n, limit in zip(fields, _LIMITS, strict=True)):
        raise ProtocolError("a report has a field that is no small integer")
    report = Report(*fields)
    if report.lost > report.highest or report.missing >> report.highest:
        raise ProtocolError("a report misses datagrams that were never sent")
    return report


class RoundTripEstimator:
    """The round trip time, from reports.

    smoothed_s : as in RFC 6298, None before the first report
    """

    MAX_REMEMBERED = 512
    MIN_RTT_WINDOW_S = 30.0
    QUEUEING_SAMPLES = 5

    def __init__(self) -> None:
        self.smoothed_s: float | None = None
        self._sent_at: OrderedDict[int, float] = OrderedDict()  # by counter
        self._samples: deque[tuple[float, float]] = deque()  # (time of the report, round trip)

    def on_sent(self, counter: int, now: float) -> None:
        """Record when a datagram was sent."""
        self._sent_at[counter] = now
        if len(self._sent_at) > self.MAX_REMEMBERED:
            self._sent_at.popitem(last=False)

    def on_report(self, report: Report, now: float) -> None:
        """Apply the sample that a report gives; each datagram gives at most one."""
        sent_at = self._sent_at.pop(report.highest, None)
        if sent_at is None:
            return
        sample = max(0.0, now - sent_at - report.ack_delay_ms * MILLISECOND)
        self._samples.append((now, sample))
        while self._samples[0][0] < now - self.MIN_RTT_WINDOW_S:
            self._samples.popleft()
        self.smoothed_s = sample if self.smoothed_s is None else self.smoothed_s + (sample - self.smoothed_s) / 8

    @property
    def min_rtt_s(self) -> float | None:
        """The shortest round trip of the last half minute: the path without queues."""
        return min((sample for _, sample in self._samples), default=None)

    @property
    def newest_queueing_s(self) -> float:
        """The smaller of the last two round trips minus the shortest: as soon as a delay in queues can be told."""
        recent = [sample for _, sample in list(self._samples)[-2:]]
        return min(recent) - (self.min_rtt_s or 0.0) if len(recent) == 2 else 0.0

    @property
    def queueing_s(self) -> float:
        """The median of the last five round trips minus the shortest: the delay in queues."""
        recent = sorted(sample for _, sample in list(self._samples)[-self.QUEUEING_SAMPLES :])
        return recent[len(recent) // 2] - (self.min_rtt_s or 0.0) if recent else 0.0
