"""Track a clip as fast as the machine can: for `extract` and `measure`."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from conf.errors import CameraError
from conf.face.control_points import CONTROL_POINT_COUNT
from conf.face.formats.dpc import MotionClip
from conf.sender.capture.clip import Clip
from conf.sender.capture.frame import Frame
from conf.sender.motion.extractor import MotionExtractor
from conf.sender.tracking.canonical_face import load_canonical_face
from conf.sender.tracking.model_files import fetch_models
from conf.sender.tracking.orientation import open_upright_clip
from conf.sender.tracking.tracker import FaceTracker, TrackedFace

EVEN_S = 0.002  # steps between frames that differ by less than this are even: containers round to milliseconds
MAX_FPS = 60.0  # of motion that is resampled because its steps are uneven, or more frequent than a DPC file may say
MAX_FILE_FPS = 1000.0

Progress = Callable[[int, int], None]  # called with the number of frames done, and of those with a face


@dataclass(frozen=True)
class ExtractedMotion:
    """The motion of a clip, its number of frames, and how many of them show a face."""

    motion: MotionClip
    frames: int
    frames_tracked: int


def track_clip(clip: Path, on_progress: Progress | None = None) -> Iterator[tuple[Frame, TrackedFace | None]]:
    """Yield each frame of a clip with the face in it, or None. Raises CameraError, ModelError."""
    with open_upright_clip(clip, fetch_models()) as source:
        yield from track_frames(source, on_progress)


def track_frames(source: Clip, on_progress: Progress | None = None) -> Iterator[tuple[Frame, TrackedFace | None]]:
    """Yield each remaining frame of an opened clip with the face in it, or None. Raises ModelError."""
    tracker = FaceTracker(fetch_models())
    faces = 0
    for count, frame in enumerate(iter(source.read, None)):
        tracked = tracker.track(frame.pixels)
        faces += tracked is not None
        yield frame, tracked
        if on_progress:
            on_progress(count + 1, faces)


def extract_motion(
    clip: Path, on_progress: Progress | None = None, on_note: Callable[[str], None] = lambda text: None
) -> ExtractedMotion:
    """Return the motion of a clip at an even frame rate, as long as the clip.

    The landmarks are extracted once and filtered twice: first to find the neutral pose, then to compute the motion with
    that pose known from the first frame on. A frame without a face repeats the one before. on_note gets what was odd
    about the clip. Raises CameraError, ModelError.
    """
    with open_upright_clip(clip, fetch_models(), on_note=on_note) as source:
        size = source.size
        tracked = [(frame.timestamp, face) for frame, face in track_frames(source, on_progress)]
    if not any(face for _, face in tracked):
        raise CameraError(f"{clip} shows no face: choose a clip in which one face is clearly visible")
    extractor = MotionExtractor(load_canonical_face(), size)
    for timestamp, face in tracked:
        if face is not None:
            extractor.update(face, timestamp)
    extractor.restart()
    displacements = np.zeros((len(tracked), CONTROL_POINT_COUNT, 3), np.float32)
    poses = np.zeros((len(tracked), 6))
    for i, (timestamp, face) in enumerate(tracked):
        if face is not None:
            motion = extractor.update(face, timestamp)
            displacements[i], poses[i] = motion.displacements, motion.pose
        elif i:
            displacements[i], poses[i] = displacements[i - 1], poses[i - 1]
    times = np.array([timestamp for timestamp, _ in tracked])
    return ExtractedMotion(
        to_even_rate(times, displacements, poses), len(tracked), sum(f is not None for _, f in tracked)
    )


def to_even_rate(
    times: NDArray[np.float64], displacements: NDArray[np.float32], poses: NDArray[np.float64], /
) -> MotionClip:
    """Return motion at an even frame rate; motion whose frames are uneven in time is interpolated linearly.

    times : (N,) seconds, rising; displacements : (N, n, 3) FAPU units; poses : (N, 6)
    """
    steps = np.diff(times)
    if not len(steps):
        return MotionClip(25.0, "fapu", displacements, poses)
    if np.ptp(steps) <= EVEN_S and steps.mean() * MAX_FILE_FPS >= 1:
        return MotionClip(1 / float(steps.mean()), "fapu", displacements, poses)
    fps = min(MAX_FPS, 1 / float(np.median(steps)))
    even = times[0] + np.arange(round((times[-1] - times[0]) * fps) + 1) / fps
    after = np.clip(np.searchsorted(times, even, side="right"), 1, len(times) - 1)
    alpha = ((even - times[after - 1]) / steps[after - 1]).clip(0.0, 1.0)[:, None]

    def interpolated(values: NDArray[np.floating]) -> NDArray[np.float64]:
        rows = values.reshape(len(values), -1)
        return np.asarray(rows[after - 1] + alpha * (rows[after] - rows[after - 1]), np.float64)

    moved = interpolated(displacements).reshape(-1, *displacements.shape[1:])
    return MotionClip(fps, "fapu", moved.astype(np.float32), interpolated(poses))
