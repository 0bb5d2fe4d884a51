"""The send budget: one answer to whether something may be sent now. Time is an argument.

Strategy. Four limits apply together. Congestion control chooses the rate level, the user may limit the kbit/s, the
circuit breaker stops everything when no reports arrive, and portrait chunks have a budget of their own that keeps the
motion from waiting. The receiver's reports drive all of them. Under a limit voice comes first: beside it goes what
leaves room for the voice of the next ten seconds.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from conf.protocol.codec.profiles import NARROWBAND, PROFILES
from conf.protocol.feedback import Report, RoundTripEstimator
from conf.protocol.portrait.chunk_budget import CHUNK_BYTES, DEFAULT_KBPS, ChunkBudget
from conf.protocol.portrait.chunks import CHUNK_HEADER_BYTES
from conf.protocol.rate_control.circuit_breaker import CircuitBreaker
from conf.protocol.rate_control.congestion import MAX_LOSS, MAX_VOICE_LOSS, CongestionControl, LossEstimator
from conf.protocol.rate_control.delivery_rate import DeliveryRate
from conf.protocol.rate_control.rate_levels import RateLevel, VoiceMode, levels_for
from conf.protocol.rate_control.rate_limit import RateLimiter
from conf.protocol.rate_control.repetition import Repetition
from conf.protocol.statistics import HEADER_BYTES
from conf.protocol.voice.formats import VoiceFormat

AUTOMATIC = "auto"
AUTOMATIC_TOP = 1  # live; 30 frames a second only on request
DATAGRAM_OVERHEAD = HEADER_BYTES + 19  # bytes that a datagram has at most beside its body: headers, framing and seal
SMOOTHING = 16  # packets: time constant of the mean size of voice packets
SEAL_BYTES = 14  # framing and seal with a short counter
VOICE_OVERHEAD = HEADER_BYTES + SEAL_BYTES + 3  # of a voice packet's data: also the fields of its body, and a composite
MAX_PAUSE_S = 5.0  # in which the link empties its queue after the level has fallen
MAX_CHUNK_DATAGRAM = DATAGRAM_OVERHEAD + CHUNK_HEADER_BYTES + CHUNK_BYTES


@dataclass(frozen=True)
class RateOptions:
    """The user's choice of the rate.

    profile : live, narrow or rich, or AUTOMATIC to follow the reports
    kbps : limit of all traffic, headers included; None for none
    portrait_kbps : long-term rate of the portrait, headers included; None for the default
    voice : the codec, or off
    """

    profile: str = AUTOMATIC
    kbps: float | None = None
    portrait_kbps: float | None = None
    voice: VoiceMode = VoiceMode.OFF


def usable_levels(rate: RateOptions) -> tuple[RateLevel, ...]:
    """Return the rate levels of the user's choice, without voice if none with voice is within the limit.

    Voice sets the cadence of motion: a fixed profile then means the levels whose motion has its precision, if there are
    any within the limit; otherwise its motion goes beside the voice of all levels.
    """
    levels = levels_for(rate.voice)
    if rate.voice is VoiceMode.OFF or not _fits(levels[-1], rate.kbps):
        return levels_for(VoiceMode.OFF)
    same = tuple(level for level in levels if PROFILES[level.profile].tables == rate.profile)
    return same if same and _fits(same[-1], rate.kbps) else levels


def highest_level(levels: Sequence[RateLevel], kbps: float | None) -> int:
    """Return the index of the highest rate level to use under a limit: the lowest level if none fits."""
    fitting = (i for i, level in enumerate(levels) if _fits(level, kbps))
    return max(next(fitting, len(levels) - 1), 0 if levels[0].voice else AUTOMATIC_TOP)


def _fits(level: RateLevel, kbps: float | None) -> bool:
    return kbps is None or level.kbps <= kbps


class SendBudget:
    """Decide what may be sent, from the receiver's reports and the user's limits.

    chunks : the part for portrait chunks
    round_trip : the round trip time so far
    jitter_ms : the interarrival jitter of the last report, None before the first
    """

    def __init__(self, rate: RateOptions, now: float) -> None:
        levels = usable_levels(rate)
        top, has_voice = highest_level(levels, rate.kbps), levels[0].voice is not None
        self.chunks = ChunkBudget(rate.portrait_kbps or DEFAULT_KBPS)
        self.round_trip = RoundTripEstimator()
        self.jitter_ms: float | None = None
        self._is_modem = rate.profile == NARROWBAND.name
        is_same = has_voice and all(PROFILES[level.profile].tables == rate.profile for level in levels)
        self._fixed_level = None if is_same or rate.profile == AUTOMATIC else RateLevel(rate.profile, 0.0)
        max_loss = MAX_VOICE_LOSS if has_voice else MAX_LOSS
        self._congestion = CongestionControl(now, top=top, start=top, levels=levels, max_loss=max_loss)
        self._repetition = Repetition()
        self._limiter = RateLimiter(rate.kbps) if rate.kbps else None
        self._breaker = CircuitBreaker(now)
        self._delivery = DeliveryRate()
        self._paused_until = now
        self._packet_bytes: dict[VoiceFormat, float] = {}  # mean of the data, of the newest format
        self._chunk_bytes = 0  # of the chunks that `on_datagrams_sent` has been told of

    @property
    def level(self) -> RateLevel:
        """The rate level for motion."""
        return self._fixed_level or self._congestion.level

    @property
    def voice_format(self) -> VoiceFormat | None:
        """The format for voice, None if it is off or the limit has no room for it."""
        level = self._congestion.level
        stage = min(self._repetition.stage, len(level.lossy))
        return level.lossy[stage - 1].voice if stage else level.voice

    @property
    def loss(self) -> LossEstimator:
        """The loss measured so far."""
        return self._congestion.loss

    def restart(self, now: float) -> None:
        """Begin with a new receiver, which counts as a report."""
        self._breaker.on_report(now)
        self.loss.reset()
        self.chunks.restart()

    def on_report(self, report: Report, now: float) -> None:
        """Apply a report."""
        self._breaker.on_report(now)
        self.round_trip.on_report(report, now)
        self._delivery.on_report(report, now)
        before, backlog_s = self._congestion.level.kbps, self._delivery.backlog_s
        has_queue = self._delivery.is_backing_up
        self._congestion.on_report(report, self.round_trip, now, delivery=self._delivery)
        if self._congestion.level.kbps != before:
            self._delivery.restart()
        if self._congestion.level.kbps < before and has_queue:
            # The new level fits the link too closely to empty the queue, behind which all of it would wait.
            self._paused_until = now + min(backlog_s, MAX_PAUSE_S)
        self.jitter_ms = float(report.jitter_ms)
        self._repetition.on_report(report, self._congestion.level.lossy, now)

    def on_sent(self, counter: int, wire_bytes: int, now: float) -> None:
        """Record the counter and the size of a datagram, headers included."""
        self.round_trip.on_sent(counter, now)
        self._delivery.on_sent(counter, wire_bytes, now)

    def is_stopped(self, now: float) -> bool:
        """Return whether nothing but probes may be sent, as no reports arrive."""
        return self._breaker.is_open(now)

    def is_paused(self, now: float) -> bool:
        """Return whether motion and voice are dropped until the link has emptied its queue."""
        return now < self._paused_until

    def consume_probe(self, now: float) -> bool:
        """Return whether a probe may be sent although everything else is stopped, and count it."""
        return self._breaker.consume_probe(now)

    def consume(self, wire_bytes: int, now: float) -> bool:
        """Return whether a datagram of this size, headers included, is within the user's limit, and count it if so."""
        return self._limiter is None or self._limiter.consume(wire_bytes, now)

    def consume_voice(self, wire_bytes: int, now: float) -> bool:
        """Return the same for a datagram with voice, which may use the limit completely."""
        return self._limiter is None or self._limiter.consume_steady(wire_bytes, now)

    def room_beside_voice(self, voice_bytes: int, now: float) -> float:
        """Return the bytes that may be sent with a voice packet now without endangering those after it.

        voice_bytes : of the datagram with the packet alone, headers included
        """
        if self._limiter is None or self.voice_format is None:
            return float("inf")
        stream_bytes = VOICE_OVERHEAD + math.ceil(self._usual_packet(self.voice_format))
        return self._limiter.room(stream_bytes, self.voice_format.packet_s, now) - voice_bytes

    def on_voice(self, voice_format: VoiceFormat, size: int) -> None:
        """Record the bytes of a packet's data: what a variable-size codec needs for the next ones."""
        usual = self._usual_packet(voice_format)
        self._packet_bytes = {voice_format: usual + (size - usual) / SMOOTHING}

    def _usual_packet(self, voice_format: VoiceFormat) -> float:
        """Return the bytes of data to expect in a packet."""
        return self._packet_bytes.get(voice_format, voice_format.nominal_bytes)

    def allows_chunk(self, now: float, room: float | None = None) -> bool:
        """Return whether a chunk would delay no motion: no high queue, no modem, no limit that motion nearly fills.

        A modem is meant by a fixed narrowband profile; the automatic one may also be due to heavy loss alone.
        room : bytes that the limit has left, if it is a datagram with voice
        """
        if self.is_stopped(now) or self._congestion.queue_is_high(self.round_trip):
            return False
        if self._is_modem:
            return False
        if room is not None:
            return room >= MAX_CHUNK_DATAGRAM - DATAGRAM_OVERHEAD + 2
        return self._limiter is None or self._limiter.has_headroom(MAX_CHUNK_DATAGRAM, now)

    def on_datagrams_sent(self, wire_bytes: int, now: float) -> None:
        """Count the datagrams sent at once, headers included, so that chunks get what the motion in them leaves."""
        chunk_bytes, self._chunk_bytes = self.chunks.bytes_sent - self._chunk_bytes, self.chunks.bytes_sent
        if wire_bytes:
            self.chunks.add_motion(wire_bytes - chunk_bytes, now)
