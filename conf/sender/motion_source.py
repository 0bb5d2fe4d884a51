"""Where motion comes from: a face that is tracked, or a recording that is played."""

import time
from collections import deque
from collections.abc import Callable
from pathlib import Path
from typing import Protocol

import numpy as np

from conf.errors import FileFormatError
from conf.face.control_points import CONTROL_POINT_COUNT
from conf.face.fapu import Fapu
from conf.face.formats.dpc import MotionClip, read_dpc
from conf.face.head_pose import NEUTRAL_POSE
from conf.protocol.messages import MotionFrame
from conf.sender.capture.video import Frame, FrameSource
from conf.sender.motion.extractor import MotionExtractor
from conf.sender.motion.mean_face import MEAN_FACE
from conf.sender.portrait.photo_builder import CapturedFace
from conf.sender.portrait.scheduler import PortraitScheduler
from conf.sender.tracking.tracker import FaceTracker, TrackedFace

REFERENCE_SIZE = (320, 240)  # what a recording is compared with: the picture the thesis counts


class MotionSource(Protocol):
    """A row of moments, each with its motion. What is not sent need not be tracked: motion is asked for apart."""

    @property
    def fps(self) -> float:
        """Moments a second, as far as is known."""

    @property
    def size(self) -> tuple[int, int]:
        """Width and height in pixels of the picture that the motion stands for."""

    @property
    def fapu_lengths(self) -> tuple[float, ...]:
        """The five FAPU distances of the face, model centimetres."""

    @property
    def calibrated(self) -> bool:
        """Whether the neutral pose is this face's own."""

    @property
    def tracker_ms(self) -> float:
        """The median time that tracking takes, 0 if nothing is tracked."""

    def next_frame(self) -> float | None:
        """Go to the next moment and return its time in seconds, None at the end. Raises CameraError."""

    def motion(self) -> MotionFrame | None:
        """Return the motion of this moment, None if there is no face."""

    def after_send(self) -> None:
        """Do what can wait until the motion of this moment has left."""


class TrackedMotionSource:
    """A face before a camera or in a clip."""

    def __init__(
        self,
        source: FrameSource,
        tracker: FaceTracker,
        extractor: MotionExtractor,
        *,
        portrait_scheduler: PortraitScheduler | None = None,
        on_frame: Callable[[Frame, TrackedFace | None], None] | None = None,
    ) -> None:
        """Join a source, a tracker and an extractor.

        studio : takes the pictures of the person that the user allowed, None takes none
        on_frame : told each frame that is sent, and the face in it
        """
        self._on_frame = on_frame
        self._source = source
        self._studio = portrait_scheduler
        self._tracker = tracker
        self._extractor = extractor
        self._frame: Frame | None = None
        self._seen: tuple[TrackedFace, MotionFrame] | None = None
        self._times_ms: deque[float] = deque(maxlen=1000)

    @property
    def fps(self) -> float:
        """The source's frames a second."""
        return self._source.fps

    @property
    def size(self) -> tuple[int, int]:
        """The source's width and height in pixels."""
        return self._source.size

    @property
    def fapu_lengths(self) -> tuple[float, ...]:
        """The units of this person's neutral face."""
        return self._extractor.fapu_distances()

    @property
    def calibrated(self) -> bool:
        """Whether the neutral pose is this person's own."""
        return self._extractor.calibrated

    @property
    def tracker_ms(self) -> float:
        """The median time of the tracker over the last thousand frames."""
        return float(np.median(self._times_ms)) if self._times_ms else 0.0

    def next_frame(self) -> float | None:
        """Read the next frame."""
        self._frame = self._source.read()
        return self._frame.timestamp if self._frame else None

    def motion(self) -> MotionFrame | None:
        """Track the face in the frame that was read."""
        assert self._frame is not None, "advance first"
        began = time.monotonic()
        tracking = self._tracker.track(self._frame.pixels)
        self._times_ms.append((time.monotonic() - began) * 1000)
        if self._on_frame:
            self._on_frame(self._frame, tracking)
        if tracking is None:
            return None
        motion = self._extractor.update(tracking, self._frame.timestamp)
        self._seen = (tracking, motion)
        return motion

    def after_send(self) -> None:
        """Let the studio look at the frame: some of what it does takes most of the time until the next."""
        seen, self._seen = self._seen, None
        if self._studio is None or self._frame is None or seen is None:
            return
        tracking, motion = seen
        shot = CapturedFace(
            self._frame.pixels, tracking.landmarks, self._extractor.neutral_points, self._extractor.fapu
        )
        self._studio.process_frame(shot, motion, tracking.presence, time.monotonic())


class RecordedMotionSource:
    """The motion of a DPC file."""

    size = REFERENCE_SIZE
    calibrated = True
    tracker_ms = 0.0

    def __init__(self, motion: MotionClip, *, loop: bool) -> None:
        """motion : (N, 50, 3) in FAPU units"""
        self.fps = motion.fps
        self.fapu_lengths = tuple(vars(Fapu.measure(MEAN_FACE)).values())
        self._motion = motion
        self._loop = loop
        self._count = -1

    def next_frame(self) -> float | None:
        """Go to the next frame of the file, from the end to the beginning when it loops."""
        self._count += 1
        if self._count >= len(self._motion.displacements) and not self._loop:
            return None
        return self._count / self.fps

    def motion(self) -> MotionFrame:
        """Return the motion of this frame; a file without poses is sent looking straight ahead."""
        index = self._count % len(self._motion.displacements)
        poses = self._motion.poses
        pose = NEUTRAL_POSE.to_vector() if poses is None else poses[index]
        return MotionFrame(self._count / self.fps, self._motion.displacements[index].astype(np.float32), pose)

    def after_send(self) -> None:
        """Do nothing: a recording has no picture."""


def open_motion_file(path: Path, *, loop: bool) -> RecordedMotionSource:
    """Open a DPC file for sending. Raises FileFormatError if it cannot be sent."""
    motion = read_dpc(path)
    if motion.displacements.shape[1] != CONTROL_POINT_COUNT:
        raise FileFormatError(path, None, f"expected {CONTROL_POINT_COUNT} control points a frame to send")
    if motion.units != "fapu":
        raise FileFormatError(
            path, None, "expected `# units: fapu`: displacements in mesh units belong to one face only"
        )
    return RecordedMotionSource(motion, loop=loop)
