"""Collect the call statistics that the stats overlay shows."""

from collections import deque
from dataclasses import dataclass
from typing import Protocol

from conf.protocol.messages import Presence
from conf.protocol.receive_leg import ReceiveLeg
from conf.protocol.statistics import MediaBytes, TrafficSnapshot
from conf.receiver.voice.call_sound import CallSound
from conf.receiver.voice.voice_status import VoiceStatus, voice_status

HISTORY_INTERVAL_S = 0.5
HISTORY_LENGTH = 120
FPS_FRAMES = 30  # frames over which the frame rate is measured


@dataclass(frozen=True)
class CallStats:
    """Statistics of the present callers together.

    state : "receiving", "no face", "waiting", "lost", "call ended" or "paused"
    fps : frames drawn a second
    points : control points in a frame, compared with the width x height pixels of the sender's video
    history : bytes a second on the wire, oldest first, over the last `history_seconds`
    voice : the callers' sound, None without any
    """

    state: str
    fps: float
    traffic: TrafficSnapshot
    points: int = 0
    width: int = 0
    height: int = 0
    round_trip_ms: float | None = None
    history: tuple[MediaBytes, ...] = ()
    history_seconds: float = 0.0
    voice: VoiceStatus | None = None


class ReceivingEnd(Protocol):
    """The end of one or more calls. streams : the receiving half of each present call, by session"""

    streams: dict[int, ReceiveLeg]

    def snapshot(self, now: float, /) -> TrafficSnapshot: ...


class CallStatsCollector:
    """Collects statistics; keeps the bit rate of the last minute and the times at which frames were drawn."""

    def __init__(self, endpoint: ReceivingEnd, sound: CallSound | None = None) -> None:
        """sound : of the call, None if it is silent"""
        self._endpoint = endpoint
        self._sound = sound
        self._drawn: deque[float] = deque(maxlen=FPS_FRAMES)
        self._history: deque[MediaBytes] = deque(maxlen=HISTORY_LENGTH)
        self._history_due = 0.0
        self._had_calls = False

    def on_frame_drawn(self, now: float) -> None:
        """Count a frame for the frame rate, and sample the bit rate when that is due."""
        self._drawn.append(now)
        if now >= self._history_due:
            self._history_due = now + HISTORY_INTERVAL_S
            self._history.append(self._endpoint.snapshot(now).media_bytes_per_second)

    def collect(self, now: float, *, paused: bool) -> CallStats:
        """Return the current statistics."""
        traffic = self._endpoint.snapshot(now)
        calls = list(self._endpoint.streams.values())
        self._had_calls |= bool(calls)
        parameters = next((call.motion.parameters for call in calls if call.motion.parameters), None)
        span = self._drawn[-1] - self._drawn[0] if len(self._drawn) > 1 else 0.0
        return CallStats(
            state="paused" if paused else state_of(calls, now, had_calls=self._had_calls),
            fps=(len(self._drawn) - 1) / span if span else 0.0,
            traffic=traffic,
            points=parameters.points if parameters else 0,
            width=parameters.width if parameters else 0,
            height=parameters.height if parameters else 0,
            round_trip_ms=max((call.round_trip_ms for call in calls if call.round_trip_ms is not None), default=None),
            history=tuple(self._history),
            history_seconds=len(self._history) * HISTORY_INTERVAL_S,
            voice=voice_status(self._endpoint.streams, self._sound, now),
        )


def state_of(calls: list[ReceiveLeg], now: float, *, had_calls: bool) -> str:
    """Return the state of the calls in one or two words: that of the best call."""
    if not calls:
        return "call ended" if had_calls else "waiting"
    if all(call.is_silent(now) for call in calls):
        return "lost" if any(call.traffic.count for call in calls) else "waiting"
    return "no face" if all(call.motion.presence is Presence.NO_FACE for call in calls) else "receiving"
