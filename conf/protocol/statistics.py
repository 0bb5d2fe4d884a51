"""Traffic figures: bytes by medium and frames over a sliding window, interarrival jitter, the cost of raw pixels.

Every rate includes the headers that the network adds. Source: RFC 3550, section 6.4.1 (interarrival jitter).
"""

from collections import deque
from dataclasses import astuple, dataclass, field

from conf.errors import ProtocolError
from conf.protocol.wire import (
    FURROWS,
    MOTION_BIT,
    PARAMETERS,
    PORTRAIT_CHUNK,
    VOICE_BIT,
    VOICE_FORMAT,
    VOICE_STATE,
    split_bodies,
)

HEADER_BYTES = 28  # IPv4 20, UDP 8; IPv6 adds 20 more
WINDOW_S = 5.0
MIN_SPAN_S = 1.0
BYTES_PER_PIXEL = 3
# What the bodies of a kind carry; the others are overhead.
_MEDIA = {
    PARAMETERS: "face", FURROWS: "face", PORTRAIT_CHUNK: "portrait", VOICE_FORMAT: "voice", VOICE_STATE: "voice",
}  # fmt: skip


@dataclass(frozen=True)
class MediaBytes:
    """Bytes, or bytes a second, by what they carry.

    overhead : headers, framing, seal, lengths in composites, reports and whatever else keeps a call up
    """

    face: float = 0
    voice: float = 0
    portrait: float = 0
    overhead: float = 0

    def __add__(self, other: "MediaBytes") -> "MediaBytes":
        return MediaBytes(*(a + b for a, b in zip(astuple(self), astuple(other), strict=True)))

    @property
    def total(self) -> float:
        """All bytes together."""
        return self.face + self.voice + self.portrait + self.overhead

    def scaled(self, factor: float) -> "MediaBytes":
        """Return each amount times a factor."""
        return MediaBytes(*(amount * factor for amount in astuple(self)))


def count_media(data: bytes, wire_bytes: int) -> MediaBytes:
    """Return the bytes of a datagram by what they carry; those of a malformed composite are overhead.

    data : its encoded body; wire_bytes : its size, headers included
    """
    try:
        parts = split_bodies(data)
    except ProtocolError:
        parts = []
    amounts = dict.fromkeys(("face", "voice", "portrait"), 0)
    for part in parts:
        if (medium := _medium(part[0])) is not None:
            amounts[medium] += len(part)
    return MediaBytes(**amounts, overhead=wire_bytes - sum(amounts.values()))


def _medium(kind: int) -> str | None:
    if kind & MOTION_BIT:
        return "face"
    return "voice" if kind & VOICE_BIT else _MEDIA.get(kind)


@dataclass(frozen=True)
class TrafficSnapshot:
    """Cost and quality of a stream, UDP/IP headers included: rates of the last seconds, counts since the start.

    wire_bytes_per_frame, raw_bytes_per_frame : bytes; raw is the sender's image as 8-bit RGB
    wire_kbps, raw_kbps : kilobits (1,000 bits) a second
    ratio : raw bytes for each byte on the wire, over the whole stream, 0 before anything has arrived
    media_bytes : since the start; media_bytes_per_second : of the last seconds
    """

    frames_received: int
    frames_lost: int
    frames_late: int
    datagrams: int
    rejected: int
    fps: float
    wire_bytes_per_frame: float
    wire_kbps: float
    raw_bytes_per_frame: int
    raw_kbps: float
    ratio: float
    jitter_ms: float
    playout_delay_ms: float
    media_bytes: MediaBytes = field(default=MediaBytes(), kw_only=True)
    media_bytes_per_second: MediaBytes = field(default=MediaBytes(), kw_only=True)

    @property
    def wire_bytes(self) -> int:
        """All bytes received, headers included."""
        return round(self.wire_bytes_per_frame * max(self.frames_received, 1))


class RateWindow:
    """Sum and count of events in the last WINDOW_S seconds and since the start."""

    def __init__(self) -> None:
        self.total: float = 0
        self.count = 0
        self._recent: deque[tuple[float, float]] = deque()
        self._sum: float = 0
        self._started_at: float | None = None

    def add(self, amount: float, now: float) -> None:
        """Add an event of `amount` at `now`."""
        self._started_at = now if self._started_at is None else self._started_at
        self.total += amount
        self.count += 1
        self._sum += amount
        self._recent.append((now, amount))
        self._drop_old(now)

    def rates(self, now: float) -> tuple[float, float]:
        """Return the amount and the number of events per second over the window that ends at `now`."""
        self._drop_old(now)
        if self._started_at is None:
            return 0.0, 0.0
        span = min(WINDOW_S, max(now - self._started_at, MIN_SPAN_S))
        return self._sum / span, len(self._recent) / span

    def _drop_old(self, now: float) -> None:
        while self._recent and self._recent[0][0] <= now - WINDOW_S:
            self._sum -= self._recent.popleft()[1]


class MediaTraffic:
    """The bytes of a stream by what they carry, in the last WINDOW_S seconds and since the start."""

    def __init__(self) -> None:
        self._windows = tuple(RateWindow() for _ in astuple(MediaBytes()))

    def add(self, amounts: MediaBytes, now: float) -> None:
        """Add a datagram."""
        for window, amount in zip(self._windows, astuple(amounts), strict=True):
            window.add(amount, now)

    @property
    def total(self) -> MediaBytes:
        """The bytes since the start."""
        return MediaBytes(*(window.total for window in self._windows))

    def rates(self, now: float) -> MediaBytes:
        """Return the bytes a second over the window that ends at `now`."""
        return MediaBytes(*(window.rates(now)[0] for window in self._windows))


class InterarrivalJitter:
    """Mean deviation of the transit time from one frame to the next, in seconds."""

    def __init__(self) -> None:
        self.seconds = 0.0
        self._transit: float | None = None

    def add(self, timestamp: float, now: float) -> None:
        """Add a frame captured at `timestamp` on the sender's clock that arrived at `now`."""
        transit = now - timestamp
        if self._transit is not None:
            self.seconds += (abs(transit - self._transit) - self.seconds) / 16
        self._transit = transit


def raw_frame_bytes(width: int, height: int) -> int:
    """Return the size of one image as raw 8-bit RGB."""
    return width * height * BYTES_PER_PIXEL


def merge_snapshots(snapshots: list[TrafficSnapshot]) -> TrafficSnapshot:
    """Return several streams' figures as one: counts and rates added, means weighted by frames, delays the longest."""
    frames = sum(s.frames_received for s in snapshots)
    wire = sum(s.wire_bytes_per_frame * max(s.frames_received, 1) for s in snapshots)
    raw = sum(s.raw_bytes_per_frame * s.frames_received for s in snapshots)
    return TrafficSnapshot(
        frames_received=frames,
        frames_lost=sum(s.frames_lost for s in snapshots),
        frames_late=sum(s.frames_late for s in snapshots),
        datagrams=sum(s.datagrams for s in snapshots),
        rejected=sum(s.rejected for s in snapshots),
        fps=sum(s.fps for s in snapshots),
        wire_bytes_per_frame=wire / max(frames, 1),
        wire_kbps=sum(s.wire_kbps for s in snapshots),
        raw_bytes_per_frame=round(raw / max(frames, 1)),
        raw_kbps=sum(s.raw_kbps for s in snapshots),
        ratio=raw / wire if wire else 0.0,
        jitter_ms=max((s.jitter_ms for s in snapshots), default=0.0),
        playout_delay_ms=max((s.playout_delay_ms for s in snapshots), default=0.0),
        media_bytes=sum((s.media_bytes for s in snapshots), MediaBytes()),
        media_bytes_per_second=sum((s.media_bytes_per_second for s in snapshots), MediaBytes()),
    )
