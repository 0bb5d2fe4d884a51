"""The send budget: one answer to whether something may be sent now. Time is an argument.

Strategy. Four limits apply together. Congestion control chooses the rate level, the user may limit the kbit/s, the
circuit breaker stops everything when no reports arrive, and portrait chunks have a budget of their own that keeps the
motion from waiting. The receiver's reports drive all of them.
"""

from dataclasses import dataclass

from conf.protocol.circuit_breaker import CircuitBreaker
from conf.protocol.codec.profiles import NARROWBAND
from conf.protocol.congestion import RATE_LEVELS, CongestionControl, LossEstimator, RateLevel
from conf.protocol.feedback import Report, RoundTripEstimator
from conf.protocol.portrait.chunk_budget import CHUNK_BYTES, DEFAULT_KBPS, ChunkBudget
from conf.protocol.portrait.chunks import CHUNK_HEADER_BYTES
from conf.protocol.rate_limit import RateLimiter
from conf.protocol.statistics import HEADER_BYTES

AUTOMATIC = "auto"
AUTOMATIC_TOP = 1  # live; 30 frames a second only on request
DATAGRAM_OVERHEAD = HEADER_BYTES + 19  # bytes that a datagram has at most beside its body: headers, framing and seal
MAX_CHUNK_DATAGRAM = DATAGRAM_OVERHEAD + CHUNK_HEADER_BYTES + CHUNK_BYTES


@dataclass(frozen=True)
class RateOptions:
    """The user's choice of the rate.

    profile : live, narrow or rich, or AUTOMATIC to follow the reports
    kbps : limit of all traffic, headers included; None for none
    portrait_kbps : long-term rate of the portrait, headers included; None for the default
    """

    profile: str = AUTOMATIC
    kbps: float | None = None
    portrait_kbps: float | None = None


def highest_level(kbps: float | None) -> int:
    """Return the index of the highest rate level to use under a limit: the lowest level if none fits."""
    fitting = (i for i, level in enumerate(RATE_LEVELS) if kbps is None or level.kbps <= kbps)
    return max(next(fitting, len(RATE_LEVELS) - 1), AUTOMATIC_TOP)


class SendBudget:
    """Decide what may be sent, from the receiver's reports and the user's limits.

    chunks : the part for portrait chunks
    round_trip : the round trip time so far
    jitter_ms : the interarrival jitter of the last report, None before the first
    """

    def __init__(self, rate: RateOptions, now: float) -> None:
        top = highest_level(rate.kbps)
        self.chunks = ChunkBudget(rate.portrait_kbps or DEFAULT_KBPS)
        self.round_trip = RoundTripEstimator()
        self.jitter_ms: float | None = None
        self._fixed_level = None if rate.profile == AUTOMATIC else RateLevel(rate.profile, 0.0)
        self._congestion = CongestionControl(now, top=top, start=top)
        self._limiter = RateLimiter(rate.kbps) if rate.kbps else None
        self._breaker = CircuitBreaker(now)
        self._chunk_bytes = 0  # of the chunks that `on_datagrams_sent` has been told of

    @property
    def level(self) -> RateLevel:
        """The rate level for motion."""
        return self._fixed_level or self._congestion.level

    @property
    def loss(self) -> LossEstimator:
        """The loss measured so far."""
        return self._congestion.loss

    def restart(self, now: float) -> None:
        """Begin with a new receiver, which counts as a report."""
        self._breaker.on_report(now)
        self.chunks.restart()

    def on_report(self, report: Report, now: float) -> None:
        """Apply a report."""
        self._breaker.on_report(now)
        self.round_trip.on_report(report, now)
        self._congestion.on_report(report, self.round_trip, now)
        self.jitter_ms = float(report.jitter_ms)

    def is_stopped(self, now: float) -> bool:
        """Return whether nothing but probes may be sent, as no reports arrive."""
        return self._breaker.is_open(now)

    def take_probe(self, now: float) -> bool:
        """Return whether a probe may be sent although everything else is stopped, and count it."""
        return self._breaker.take_probe(now)

    def take(self, wire_bytes: int, now: float) -> bool:
        """Return whether a datagram of this size, headers included, is within the user's limit, and count it if so."""
        return self._limiter is None or self._limiter.take(wire_bytes, now)

    def allows_chunk(self, now: float) -> bool:
        """Return whether a chunk would delay no motion: no high queue, no modem, no limit that motion nearly fills.

        A modem is meant by a fixed narrowband profile; the automatic one may also be due to heavy loss alone.
        """
        if self.is_stopped(now) or self._congestion.queue_is_high(self.round_trip):
            return False
        if self._fixed_level and self._fixed_level.profile == NARROWBAND.name:
            return False
        return self._limiter is None or self._limiter.has_headroom(MAX_CHUNK_DATAGRAM, now)

    def on_datagrams_sent(self, wire_bytes: int, now: float) -> None:
        """Count the datagrams sent at once, headers included, so that chunks get what the motion in them leaves."""
        chunk_bytes, self._chunk_bytes = self.chunks.bytes_sent - self._chunk_bytes, self.chunks.bytes_sent
        if wire_bytes:
            self.chunks.add_motion(wire_bytes - chunk_bytes, now)
