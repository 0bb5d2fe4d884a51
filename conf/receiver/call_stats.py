"""From the calls' figures to what the meter shows."""

from collections import deque

from conf.protocol.messages import Presence
from conf.protocol.motion.inbound import InboundMotion
from conf.protocol.receiver_endpoint import ReceiverEndpoint
from conf.receiver.stats_overlay import CallStats

HISTORY_EVERY_S = 0.5
HISTORY_LENGTH = 120


class CallStatsCollector:
    """Makes the meter's readings; remembers the last minute's traffic and how fast pictures were drawn."""

    def __init__(self, host: ReceiverEndpoint) -> None:
        self._host = host
        self._drawn: deque[float] = deque(maxlen=30)
        self._history: deque[float] = deque(maxlen=HISTORY_LENGTH)
        self._history_due = 0.0

    def on_frame_drawn(self, now: float) -> None:
        """Note that a picture was drawn."""
        self._drawn.append(now)
        if now >= self._history_due:
            self._history_due = now + HISTORY_EVERY_S
            self._history.append(self._host.snapshot(now).wire_kbps)

    def collect(self, now: float, *, paused: bool) -> CallStats:
        """Return what the meter shows now, all callers together."""
        snapshot = self._host.snapshot(now)
        calls = list(self._host.streams.values())
        parameters = next((call.parameters for call in calls if call.parameters), None)
        trips = [call.round_trip_ms for call in calls if call.round_trip_ms is not None]
        span = self._drawn[-1] - self._drawn[0] if len(self._drawn) > 1 else 0.0
        return CallStats(
            state="paused" if paused else state_of(calls, now, had_calls=snapshot.datagrams > 0),
            fps=(len(self._drawn) - 1) / span if span else 0.0,
            bytes_per_frame=snapshot.wire_bytes_per_frame,
            wire_kbps=snapshot.wire_kbps,
            raw_bytes_per_frame=snapshot.raw_bytes_per_frame,
            raw_kbps=snapshot.raw_kbps,
            ratio=snapshot.ratio,
            saved_percent=100 * (1 - 1 / snapshot.ratio) if snapshot.ratio > 0 else 0.0,
            points=parameters.points if parameters else 0,
            width=parameters.width if parameters else 0,
            height=parameters.height if parameters else 0,
            frames_received=snapshot.frames_received,
            frames_lost=snapshot.frames_lost,
            frames_late=snapshot.frames_late,
            playout_delay_ms=snapshot.playout_delay_ms,
            jitter_ms=snapshot.jitter_ms,
            round_trip_ms=max(trips) if trips else None,
            history=tuple(self._history),
            history_seconds=len(self._history) * HISTORY_EVERY_S,
        )


def state_of(calls: list[InboundMotion], now: float, *, had_calls: bool) -> str:
    """Return one word for how the calls stand: the best of them counts."""
    if not calls:
        return "call ended" if had_calls else "waiting"
    if all(call.is_silent(now) for call in calls):
        return "lost" if any(call.traffic.count for call in calls) else "waiting"
    return "no face" if all(call.presence is Presence.NO_FACE for call in calls) else "receiving"
