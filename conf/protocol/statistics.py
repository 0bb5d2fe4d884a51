"""Counting: bytes and frames over a sliding window, interarrival jitter, and what raw pixels would have cost.

Every rate counts the headers that the network adds. Source: RFC 3550, section 6.4.1 (interarrival jitter).
"""

from collections import deque
from dataclasses import dataclass

HEADER_BYTES = 28  # IPv4 20, UDP 8; IPv6 adds 20 more
WINDOW_S = 5.0
BYTES_PER_PIXEL = 3


@dataclass(frozen=True)
class TrafficSnapshot:
    """What a stream costs, UDP/IP headers counted, and how it fares: rates of the last seconds, counts since the start.

    wire_bytes_per_frame and raw_bytes_per_frame : bytes, raw is the sender's picture as 8-bit RGB
    wire_kbps and raw_kbps : kilobits (1,000 bits) a second
    ratio : raw bytes for each byte on the wire, of the whole stream, 0 before anything came
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


class RateWindow:
    """Sum and count of what happened in the last WINDOW_S seconds, and since the start."""

    def __init__(self) -> None:
        self.total = 0
        self.count = 0
        self._recent: deque[tuple[float, int]] = deque()
        self._sum = 0
        self._started: float | None = None

    def add(self, amount: int, now: float) -> None:
        """Note `amount` at `now`."""
        self._started = now if self._started is None else self._started
        self.total += amount
        self.count += 1
        self._sum += amount
        self._recent.append((now, amount))
        self._forget(now)

    def rates(self, now: float) -> tuple[float, float]:
        """Return the amount and the number of events per second over the window that ends at `now`."""
        self._forget(now)
        if self._started is None:
            return 0.0, 0.0
        span = min(WINDOW_S, max(now - self._started, 1.0))
        return self._sum / span, len(self._recent) / span

    def _forget(self, now: float) -> None:
        while self._recent and self._recent[0][0] <= now - WINDOW_S:
            self._sum -= self._recent.popleft()[1]


class InterarrivalJitter:
    """Mean deviation of the transit time from one frame to the next, in seconds."""

    def __init__(self) -> None:
        self.seconds = 0.0
        self._transit: float | None = None

    def add(self, timestamp: float, now: float) -> None:
        """Note a frame captured at `timestamp` on the sender's clock that came at `now`."""
        transit = now - timestamp
        if self._transit is not None:
            self.seconds += (abs(transit - self._transit) - self.seconds) / 16
        self._transit = transit


def raw_frame_bytes(width: int, height: int) -> int:
    """Return what one picture of this size costs as raw 8-bit RGB."""
    return width * height * BYTES_PER_PIXEL


def merge_snapshots(snapshots: list[TrafficSnapshot]) -> TrafficSnapshot:
    """Return several streams' figures as one: counts and rates added, means weighted by frames, delays the longest."""
    frames = sum(s.frames_received for s in snapshots)
    per_frame = max(frames, 1)
    wire = sum(s.wire_bytes_per_frame * max(s.frames_received, 1) for s in snapshots)
    raw = sum(s.raw_bytes_per_frame * s.frames_received for s in snapshots)
    return TrafficSnapshot(
        frames_received=frames,
        frames_lost=sum(s.frames_lost for s in snapshots),
        frames_late=sum(s.frames_late for s in snapshots),
        datagrams=sum(s.datagrams for s in snapshots),
        rejected=sum(s.rejected for s in snapshots),
        fps=sum(s.fps for s in snapshots),
        wire_bytes_per_frame=wire / per_frame,
        wire_kbps=sum(s.wire_kbps for s in snapshots),
        raw_bytes_per_frame=round(raw / per_frame),
        raw_kbps=sum(s.raw_kbps for s in snapshots),
        ratio=raw / wire if wire else 0.0,
        jitter_ms=max((s.jitter_ms for s in snapshots), default=0.0),
        playout_delay_ms=max((s.playout_delay_ms for s in snapshots), default=0.0),
    )
