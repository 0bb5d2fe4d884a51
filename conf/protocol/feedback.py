"""What the receiver tells the sender twice a second, and the round trip that follows from it.

Strategy. A report names the highest counter it has seen and how long ago that came, so the counter is the echo: the
sender knows when it sent it, and no datagram need carry a time for it. Losses are counted since the start, not since
the last report, so a lost report loses nothing. What is missing travels instead of what has come: it is mostly nothing.
Source: RFC 3550, 6.4 (reports, round trip); RFC 6298 (smoothing).
"""

from collections import OrderedDict, deque
from dataclasses import astuple, dataclass

import msgpack

from conf.errors import ProtocolError
from conf.protocol.session.replay_window import WINDOW, ReplayWindow
from conf.protocol.statistics import InterarrivalJitter

REPORT_EVERY_S = 0.5
MILLISECOND = 1e-3
MAX_MILLISECONDS = 0xFFFF
# The largest value of each field on the wire.
_LIMITS = (0xFFFFFFFF, (1 << WINDOW - 1) - 1, 0xFFFFFFFF, MAX_MILLISECONDS, MAX_MILLISECONDS)
MAX_REPORT_BYTES = 32


@dataclass(frozen=True)
class Report:
    """How the sender's datagrams have come.

    highest : the highest counter received
    missing : bit i is set if counter highest - 1 - i has not come, for the 63 before the highest
    lost : datagrams lost since the start
    jitter_ms : interarrival jitter
    hold_ms : how long ago the highest came
    """

    highest: int
    missing: int
    lost: int
    jitter_ms: int
    ack_delay_ms: int

    def received(self, counter: int) -> bool:
        """Return whether the report says that `counter` has come; False also if it does not reach back so far."""
        behind = self.highest - counter
        return behind == 0 or (0 < behind < WINDOW and not self.missing >> (behind - 1) & 1)

    def acknowledged(self) -> list[int]:
        """Return the counters that have come, newest first, as far back as the report reaches."""
        return [c for c in range(self.highest, max(-1, self.highest - WINDOW), -1) if self.received(c)]


def encode_report(report: Report) -> bytes:
    """Return a report's bytes: a msgpack array of five integers, usually 9 B."""
    data: bytes = msgpack.packb(astuple(report))
    return data


def decode_report(data: bytes) -> Report:
    """Return the report. Raises ProtocolError, whatever the bytes, and no other exception."""
    if len(data) > MAX_REPORT_BYTES:
        raise ProtocolError("a report is too long")
    try:
        fields = msgpack.unpackb(data, max_array_len=5, max_map_len=0, max_ext_len=0, max_str_len=0, max_bin_len=0)
    except (ValueError, msgpack.UnpackException) as error:
        raise ProtocolError("a report is not msgpack") from error
    if type(fields) is not list or len(fields) != len(_LIMITS):
        raise ProtocolError("a report is not an array of five")
    if any(type(n) is not int or not 0 <= n <= most for n, most in zip(fields, _LIMITS, strict=True)):
        raise ProtocolError("a report has a field that is no small integer")
    report = Report(*fields)
    if report.lost > report.highest or report.missing >> report.highest:
        raise ProtocolError("a report misses what was never sent")
    return report


class ReceptionStats:
    """The receiver's log of one session, from which its reports are made."""

    def __init__(self) -> None:
        self.jitter = InterarrivalJitter()
        self._window = ReplayWindow()
        self._count = 0
        self._newest = -1
        self._highest_came = 0.0
        self._due = float("-inf")

    def add(self, counter: int, now: float, *, timestamp: float | None = None, decodable: bool = True) -> None:
        """Note a datagram under a valid seal.

        timestamp : of its newest frame, seconds on the sender's clock
        understood : what it carried could be used; what could not is not lost, but is not acknowledged either
        """
        self._count += 1
        self._newest = max(self._newest, counter)
        if not decodable:
            return
        if counter > self._window.highest:
            self._highest_came = now
        self._window.accept(counter)
        if timestamp is not None:
            self.jitter.add(timestamp, now)

    @property
    def lost(self) -> int:
        """Datagrams lost since the start."""
        return self._newest + 1 - self._count

    def report(self, now: float) -> Report | None:
        """Return a report when one is due, every half second once something has come."""
        highest = self._window.highest
        if now < self._due or highest < 0:
            return None
        self._due = now + REPORT_EVERY_S
        reach = min(highest, WINDOW - 1)
        return Report(
            highest=highest,
            missing=~(self._window.received >> 1) & ((1 << reach) - 1),
            lost=min(self.lost, highest),
            jitter_ms=_milliseconds(self.jitter.seconds),
            ack_delay_ms=_milliseconds(now - self._highest_came),
        )


class RoundTripEstimator:
    """The time to the receiver and back, from reports.

    smoothed_s and deviation_s : as in RFC 6298, None before the first report
    """

    REMEMBERED = 512
    FLOOR_S = 30.0

    def __init__(self) -> None:
        self.smoothed_s: float | None = None
        self.deviation_s: float | None = None
        self._sent: OrderedDict[int, float] = OrderedDict()
        self._samples: deque[tuple[float, float]] = deque()

    def sent(self, counter: int, now: float) -> None:
        """Note when a datagram was sent."""
        self._sent[counter] = now
        if len(self._sent) > self.REMEMBERED:
            self._sent.popitem(last=False)

    def on_report(self, report: Report, now: float) -> None:
        """Take the sample that a report gives; each datagram gives at most one."""
        sent = self._sent.pop(report.highest, None)
        if sent is None:
            return
        sample = max(0.0, now - sent - report.ack_delay_ms * MILLISECOND)
        self._samples.append((now, sample))
        while self._samples[0][0] < now - self.FLOOR_S:
            self._samples.popleft()
        if self.smoothed_s is None or self.deviation_s is None:
            self.smoothed_s, self.deviation_s = sample, sample / 2
            return
        self.deviation_s += (abs(sample - self.smoothed_s) - self.deviation_s) / 4
        self.smoothed_s += (sample - self.smoothed_s) / 8

    @property
    def min_rtt_s(self) -> float | None:
        """The shortest round trip of the last half minute: the way without queues."""
        return min((sample for _, sample in self._samples), default=None)

    @property
    def queueing_s(self) -> float:
        """How much longer than the shortest the median of the last five round trips was: what queues add."""
        recent = sorted(sample for _, sample in list(self._samples)[-5:])
        return recent[len(recent) // 2] - (self.min_rtt_s or 0.0) if recent else 0.0


def _milliseconds(seconds: float) -> int:
    return min(MAX_MILLISECONDS, max(0, round(seconds / MILLISECOND)))
