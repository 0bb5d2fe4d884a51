"""The capturing part of a loop: from a motion source to motion, each frame at its time."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from enum import Enum, auto
from typing import Protocol

from conf.errors import CameraError
from conf.protocol.messages import MotionFrame
from conf.protocol.motion.outbound import OutboundMotion
from conf.sender.frame_pacer import FramePacer
from conf.sender.motion_source import MotionSource
from conf.transport.fault_tolerance import CAMERA_LIMIT_S, FaultTolerance

RETRY_S = 0.25  # between two attempts to read a camera that fails
IDLE_S = 0.05  # until a capture that is off looks whether it still is


class CaptureMode(Enum):
    """OFF : nothing is tracked and a camera is released; PREVIEW : a camera's images are shown only; ON : all."""

    OFF = auto()
    PREVIEW = auto()
    ON = auto()


@dataclass(frozen=True)
class CapturedMotion:
    """What a frame shows.

    motion : None without a face
    fapu_lengths : the five FAPU distances of the person's neutral face, cm
    """

    timestamp: float
    motion: MotionFrame | None
    fapu_lengths: tuple[float, ...]


class MotionOutlet(Protocol):
    """Where captured motion goes: the sending half of a call."""

    @property
    def outbound(self) -> OutboundMotion: ...
    def send_frame(self, frame: MotionFrame, now: float, /) -> None: ...
    def send_no_face(self, timestamp: float, now: float, /) -> None: ...


class FaceCapture:
    """Reads and tracks one frame after another. The program calls `step`, then `pop`.

    mode : may be changed between steps; no clip begins before it is ON for the first time
    frames, tracked : numbers of frames captured, and of those with a face
    has_face : whether the newest frame showed one
    """

    def __init__(self, source: MotionSource, fps: float, *, mode: CaptureMode = CaptureMode.ON) -> None:
        """fps : frames a second to capture, as far as the source has as many"""
        self.mode = mode
        self.frames = self.tracked = 0
        self.has_face = False
        self._source = source
        self._pacer = FramePacer(fps)
        self._camera = FaultTolerance(CAMERA_LIMIT_S)
        self._captured: CapturedMotion | None = None
        self._now = 0.0
        self._running = self._steps()

    @property
    def note(self) -> str:
        """What to tell the user while the camera fails, "" otherwise."""
        return self._camera.note

    @property
    def calibrated(self) -> bool:
        """Whether the neutral pose is this person's own."""
        return self._source.calibrated

    @property
    def tracker_ms(self) -> float:
        """Median duration of tracking."""
        return self._source.tracker_ms

    def set_fps(self, fps: float) -> None:
        """Capture so many frames a second from now on."""
        self._pacer.fps = fps

    def set_portrait(self, *, is_allowed: bool) -> None:
        """Make images of the person, or none, from the next frame on."""
        self._source.makes_portrait = is_allowed

    @property
    def is_working(self) -> bool:
        """Whether a frame has come since the start, or since the last restart."""
        return self._camera.has_worked

    def source_time(self, now: float) -> float | None:
        """Return the time on the source's clock at `now`, None before the first frame of a clip."""
        at = self._pacer.source_time(now)
        return now if at is None and self._source.is_live else at  # a camera's frames have the machine's time

    def step(self, now: float) -> float | None:
        """Do what is due at `now`, seconds on a monotonic clock, which reading a camera and tracking a face may delay.

        Returns the seconds until the next step, None at the end of the source.
        Raises CameraError when the camera has failed for 5 s, or at once if it has never worked.
        """
        self._now = now
        return next(self._running, None)

    def restart(self) -> None:
        """Go on after an error, as if the camera had never worked."""
        self._camera = FaultTolerance(CAMERA_LIMIT_S)
        self._running = self._steps()

    def pop(self) -> CapturedMotion | None:
        """Return what the last step has captured, once."""
        captured, self._captured = self._captured, None
        return captured

    def _steps(self) -> Iterator[float]:
        """Yield the seconds until the next step. A step starts wherever `self._now` must be up to date."""
        has_started = False
        while True:
            mode, is_live = self.mode, self._source.is_live
            has_started |= mode is CaptureMode.ON
            if not has_started and not is_live:
                yield IDLE_S
                continue
            if mode is CaptureMode.OFF:
                self.has_face = False
                if is_live:
                    self._source.release()
                    yield IDLE_S
                    continue
            try:
                timestamp = self._source.next_frame()
            except CameraError as error:
                self._camera.on_failure(error, self._now)
                yield from self._wait_until(self._now + RETRY_S)
                continue
            self._camera.on_success()
            if timestamp is None:
                return
            yield 0.0
            self.frames += 1
            delay = self._pacer.delay_for(timestamp, self._now)
            if delay is None:
                continue
            yield from self._wait_until(self._now + delay)
            if mode is CaptureMode.ON:
                yield from self._track(timestamp)
            elif mode is CaptureMode.PREVIEW:
                self._source.show()

    def _track(self, timestamp: float) -> Iterator[float]:
        motion = self._source.motion()
        self.has_face = motion is not None
        self.tracked += self.has_face
        self._captured = CapturedMotion(timestamp, motion, self._source.fapu_lengths)
        yield 0.0  # for the program to send it
        self._source.after_send(self._now)

    def _wait_until(self, until: float) -> Iterator[float]:
        while self._now < until:
            yield until - self._now


def send_motion(outlet: MotionOutlet, captured: CapturedMotion, now: float) -> None:
    """Send what a frame shows."""
    if captured.motion is None:
        outlet.send_no_face(captured.timestamp, now)
        return
    outbound = outlet.outbound
    outbound.parameters = replace(outbound.parameters, fapu=captured.fapu_lengths)
    outlet.send_frame(captured.motion, now)
