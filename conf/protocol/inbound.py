"""The receiving half without I/O: datagrams in, motion out. Time is an argument, sockets live in receiver/udp.py."""

from conf.errors import ProtocolError
from conf.protocol.jitter_buffer import JitterBuffer, Playout
from conf.protocol.messages import KeepAlive, MotionFrame, Presence, StreamParameters
from conf.protocol.sequence import ReceptionLog
from conf.protocol.statistics import (
    HEADER_BYTES,
    InterarrivalJitter,
    RateWindow,
    TrafficSnapshot,
    raw_bytes,
)
from conf.protocol.wire import decode

SILENCE_S = 3.0


class Inbound:
    """Take datagrams, keep what is sound, and play the motion at its time."""

    def __init__(self) -> None:
        self.parameters: StreamParameters | None = None
        self.presence = Presence.FACE
        self.rejected = 0
        self.frames = RateWindow()
        self.traffic = RateWindow()
        self._buffer = JitterBuffer()
        self._log = ReceptionLog()
        self._jitter = InterarrivalJitter()
        self._heard_at: float | None = None

    def receive_datagram(self, data: bytes, now: float) -> None:
        """Take one datagram. A bad one is counted in `rejected` and changes nothing else."""
        try:
            datagram = decode(data)
        except ProtocolError:
            self.rejected += 1
            return
        self.traffic.add(len(data) + HEADER_BYTES, now)
        if not self._log.add(datagram.sequence):
            return
        self._heard_at = now
        match datagram.message:
            case StreamParameters() as parameters:
                self.parameters = parameters
            case KeepAlive(presence=presence):
                self.presence = presence
            case MotionFrame() as frame:
                self._take_frame(frame, now)

    def play(self, now: float) -> Playout | None:
        """Return the motion to draw at `now`, or None before there is any."""
        return self._buffer.play(now)

    def silent(self, now: float) -> bool:
        """Say whether the sender has not been heard for a while, or never."""
        return self._heard_at is None or now - self._heard_at > SILENCE_S

    def snapshot(self, now: float) -> TrafficSnapshot:
        """Return the figures of the meter."""
        bytes_a_second, _ = self.traffic.rates(now)
        _, fps = self.frames.rates(now)
        raw = raw_bytes(self.parameters.width, self.parameters.height) if self.parameters else 0
        frames = max(self.frames.count, 1)
        return TrafficSnapshot(
            frames_received=self.frames.count,
            frames_lost=self._log.lost,
            frames_late=self._buffer.late,
            datagrams=self.traffic.count,
            rejected=self.rejected,
            fps=fps,
            wire_bytes_per_frame=self.traffic.total / frames,
            wire_kbps=bytes_a_second * 8 / 1000,
            raw_bytes_per_frame=raw,
            raw_kbps=raw * (self.parameters.fps if self.parameters else 0.0) * 8 / 1000,
            ratio=raw * self.frames.count / self.traffic.total if self.traffic.total else 0.0,
            jitter_ms=self._jitter.seconds * 1000,
            playout_delay_ms=self._buffer.playout_delay_s * 1000,
        )

    def _take_frame(self, frame: MotionFrame, now: float) -> None:
        if self.parameters is None or len(frame.displacements) != self.parameters.points:
            return
        self.presence = Presence.FACE
        self.frames.add(1, now)
        self._jitter.add(frame.timestamp, now)
        self._buffer.add(frame, now)
