"""Where motion comes from: a tracked face, or a recording.

A source goes from frame to frame; motion is requested separately, so that only frames that are sent are tracked.
"""

import time
from collections import deque
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

import numpy as np

from conf.errors import FileFormatError
from conf.face.control_points import CONTROL_POINT_COUNT
from conf.face.fapu import Fapu
from conf.face.formats.dpc import MotionClip, read_dpc
from conf.face.head_pose import NEUTRAL_POSE
from conf.protocol.messages import MotionFrame
from conf.sender.capture.camera import Camera
from conf.sender.capture.frame import Frame
from conf.sender.motion.extractor import MotionExtractor
from conf.sender.motion.furrows import FurrowEstimator
from conf.sender.motion.mean_face import MEAN_FACE
from conf.sender.portrait.captured_face import CapturedFace
from conf.sender.tracking.orientation import UprightCamera
from conf.sender.tracking.tracker import FaceTracker, TrackedFace

if TYPE_CHECKING:
    from conf.sender.capture.clip import Clip  # with PyAV, which a camera does not need

REFERENCE_SIZE = (320, 240)  # px of a recording's frames: those of the thesis


class PortraitFrames(Protocol):
    """What makes images of the person from frames, a little at a time."""

    def process_frame(self, face: CapturedFace, motion: MotionFrame, presence: float, now: float) -> None: ...


class TrackedMotionSource:
    """A face before a camera or in a clip.

    fps : frames per second, as far as known; size : width and height of the frames, px
    is_live : whether it is a camera, whose frames cannot wait, rather than a clip
    makes_portrait : whether images of the person are made, if there is a portrait scheduler
    """

    def __init__(
        self,
        source: "Camera | UprightCamera | Clip",
        tracker: FaceTracker,
        extractor: MotionExtractor,
        *,
        portrait_scheduler: PortraitFrames | None = None,
        on_frame: Callable[[Frame, TrackedFace | None], None] | None = None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """Combine a source, a tracker and an extractor.

        portrait_scheduler : None if the user does not allow images of the person to be sent
        on_frame : called with each frame that is sent, and the face in it
        clock : measures the tracker's duration
        """
        self.fps, self.size = source.fps, source.size
        self.is_live = source.is_live
        self.makes_portrait = True
        self._source = source
        self._tracker = tracker
        self._extractor = extractor
        self._furrows = FurrowEstimator()
        self._portrait_scheduler = portrait_scheduler
        self._on_frame = on_frame
        self._clock = clock
        self._frame: Frame | None = None
        self._sent: tuple[TrackedFace, MotionFrame] | None = None
        self._times_ms: deque[float] = deque(maxlen=1000)

    @property
    def fapu_lengths(self) -> tuple[float, ...]:
        """The five FAPU distances of this person's neutral face, cm."""
        return self._extractor.fapu.distances

    @property
    def calibrated(self) -> bool:
        """Whether the neutral pose is this person's own."""
        return self._extractor.calibrated

    @property
    def tracker_ms(self) -> float:
        """Median duration of tracking over the last thousand frames."""
        return float(np.median(self._times_ms)) if self._times_ms else 0.0

    def next_frame(self) -> float | None:
        """Read the next frame and return its time in seconds, None at the end. Raises CameraError."""
        self._frame = self._source.read()
        return self._frame.timestamp if self._frame else None

    def motion(self) -> MotionFrame | None:
        """Track the face in the frame that was read and return its motion, None if there is no face."""
        assert self._frame is not None, "call next_frame first"
        start = self._clock()
        tracked = self._tracker.track(self._frame.pixels)
        self._times_ms.append((self._clock() - start) * 1000)
        if self._on_frame:
            self._on_frame(self._frame, tracked)
        if tracked is None:
            return None
        motion = self._extractor.update(tracked, self._frame.timestamp)
        motion = self._furrows.add_furrows(motion, tracked, self._frame.pixels)
        self._sent = (tracked, motion)
        return motion

    def show(self) -> None:
        """Pass the frame that was read to `on_frame` only."""
        if self._on_frame and self._frame is not None:
            self._on_frame(self._frame, None)

    def release(self) -> None:
        """Release the camera until the next frame is read; a clip stays open."""
        if self.is_live:
            self._source.release()

    def after_send(self, now: float) -> None:
        """Pass the frame to the portrait scheduler, which may need almost a frame's interval."""
        sent, self._sent = self._sent, None
        if not self.makes_portrait or self._portrait_scheduler is None or self._frame is None or sent is None:
            return
        tracked, motion = sent
        face = CapturedFace(self._frame.pixels, tracked.landmarks, self._extractor.neutral_points, self._extractor.fapu)
        self._portrait_scheduler.process_frame(face, motion, tracked.presence, now)


class RecordedMotionSource:
    """The motion of a DPC file."""

    size = REFERENCE_SIZE
    is_live = False
    makes_portrait = False
    calibrated = True
    tracker_ms = 0.0

    def __init__(self, clip: MotionClip, *, loop: bool) -> None:
        """clip : N frames of 50 control points, in FAPU units"""
        self.fps = clip.fps
        self.fapu_lengths = Fapu.measure(MEAN_FACE).distances
        self._clip = clip
        self._loop = loop
        self._frame_number = -1

    def next_frame(self) -> float | None:
        """Go to the next frame of the file, from the last to the first if it loops."""
        self._frame_number += 1
        if self._frame_number >= len(self._clip.displacements) and not self._loop:
            return None
        return self._frame_number / self.fps

    def motion(self) -> MotionFrame:
        """Return the motion of this frame; without poses in the file, the head faces the camera."""
        index = self._frame_number % len(self._clip.displacements)
        pose = NEUTRAL_POSE.to_vector() if self._clip.poses is None else self._clip.poses[index]
        displacements = self._clip.displacements[index].astype(np.float32)
        return MotionFrame(self._frame_number / self.fps, displacements, pose)

    def show(self) -> None:
        """Do nothing: a recording has no image."""

    def release(self) -> None:
        """Do nothing: a recording has no device."""

    def after_send(self, now: float) -> None:
        """Do nothing: a recording has no image."""


MotionSource = TrackedMotionSource | RecordedMotionSource


def open_motion_file(path: Path, *, loop: bool) -> RecordedMotionSource:
    """Open a DPC file for sending. Raises FileFormatError if it cannot be sent."""
    clip = read_dpc(path)
    if clip.displacements.shape[1] != CONTROL_POINT_COUNT:
        raise FileFormatError(path, None, f"expected {CONTROL_POINT_COUNT} control points a frame to send")
    if clip.units != "fapu":
        reason = "expected `# units: fapu`: displacements in mesh units belong to one face only"
        raise FileFormatError(path, None, reason)
    return RecordedMotionSource(clip, loop=loop)
