"""The sending loop: frames from a source, motion to the wire.

The way of one frame is read here from top to bottom; every step it calls is a module of its own.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from conf.protocol.outbound import Outbound
from conf.sender.motion import MotionExtractor
from conf.sender.pace import Pace
from conf.sender.sources import Frame, FrameSource
from conf.sender.tracker import FaceTracker
from conf.sender.udp import SenderSocket

STATUS_EVERY_S = 0.25


@dataclass(frozen=True)
class SenderStatus:
    """How the sending goes: counts since the start, rates of the last seconds, UDP/IP headers counted."""

    frames_captured: int
    frames_tracked: int
    frames_sent: int
    tracker_ms_median: float
    wire_bytes_per_frame: float
    wire_kbps: float
    face: bool
    calibrated: bool


class SendingLoop:
    """Track the face in each frame of a source and send its motion."""

    def __init__(
        self,
        source: FrameSource,
        tracker: FaceTracker,
        extractor: MotionExtractor,
        outbound: Outbound,
        link: SenderSocket,
    ) -> None:
        self._source = source
        self._tracker = tracker
        self._extractor = extractor
        self._outbound = outbound
        self._link = link
        self._pace = Pace(outbound.parameters.fps)
        self._captured = self._tracked = 0
        self._tracker_ms: list[float] = []
        self._face = False

    def run(
        self, *, seconds: float | None = None, on_status: Callable[[SenderStatus], None] | None = None
    ) -> SenderStatus:
        """Send until the source ends, or for `seconds`. Raises CameraError when the camera stops, NetworkError."""
        began = status_due = time.monotonic()
        while (frame := self._source.read()) is not None:
            now = time.monotonic()
            if seconds is not None and now - began >= seconds:
                break
            self._captured += 1
            wait = self._pace.wait(frame.timestamp, now)
            if wait is None:
                continue
            if wait > 0:
                time.sleep(wait)
            self._send(frame)
            if on_status and now >= status_due:
                status_due = now + STATUS_EVERY_S
                on_status(self.status())
        return self.status()

    def status(self) -> SenderStatus:
        """Return how it goes now."""
        now = time.monotonic()
        traffic = self._outbound.traffic
        return SenderStatus(
            frames_captured=self._captured,
            frames_tracked=self._tracked,
            frames_sent=self._outbound.frames_sent,
            tracker_ms_median=float(np.median(self._tracker_ms)) if self._tracker_ms else 0.0,
            wire_bytes_per_frame=traffic.total / max(self._outbound.frames_sent, 1),
            wire_kbps=traffic.rates(now)[0] * 8 / 1000,
            face=self._face,
            calibrated=self._extractor.calibrated,
        )

    def _send(self, frame: Frame) -> None:
        began = time.monotonic()
        tracking = self._tracker.track(frame.pixels)
        now = time.monotonic()
        self._tracker_ms.append((now - began) * 1000)
        del self._tracker_ms[:-1000]
        self._face = tracking is not None
        if tracking is None:
            self._outbound.send_absence(frame.timestamp, now)
        else:
            self._tracked += 1
            motion = self._extractor.update(tracking, frame.timestamp)
            self._outbound.parameters = replace(self._outbound.parameters, fapu=self._extractor.fapu_lengths())
            self._outbound.send_frame(motion, now)
        self._link.send(self._outbound.datagrams_to_send(now))
