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
from conf.sender.tracking.blendshape_network import BLENDSHAPE_NAMES
from conf.sender.tracking.canonical_face import load_canonical_face
from conf.sender.tracking.model_files import fetch_models
from conf.sender.tracking.orientation import open_upright_clip
from conf.sender.tracking.tracker import FaceTracker, TrackedFace

EVEN_S = 0.002  # steps between frames that differ by less than this are even: containers round to milliseconds
MAX_FPS = 60.0  # of motion that is resampled because its steps are uneven, or more frequent than a DPC file may say
MAX_FILE_FPS = 1000.0
POSE_VALUES = 6  # of HeadPose.to_vector

Progress = Callable[[int, int], None]  # called with the number of frames done, and of those with a face


@dataclass(frozen=True)
class ExtractedMotion:
    """The motion of a clip, its number of frames, and how many of them show a face.

    shapes : (N, 52) the tracker's blendshapes in the frames of the motion, in the order of BLENDSHAPE_NAMES
    """

    motion: MotionClip
    shapes: NDArray[np.float64]
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
    rows = np.zeros((len(tracked), 3 * CONTROL_POINT_COUNT + POSE_VALUES + len(BLENDSHAPE_NAMES)))
    for i, (timestamp, face) in enumerate(tracked):
        if face is not None:
            motion = extractor.update(face, timestamp)
            rows[i] = np.concatenate([motion.displacements.ravel(), motion.pose, face.blendshapes])
        elif i:
            rows[i] = rows[i - 1]
    fps, even = to_even_rate(np.array([timestamp for timestamp, _ in tracked]), rows)
    displacements, poses, shapes = np.split(even, np.cumsum([3 * CONTROL_POINT_COUNT, POSE_VALUES]), axis=1)
    extracted = MotionClip(fps, "fapu", displacements.reshape(len(even), -1, 3).astype(np.float32), poses)
    return ExtractedMotion(extracted, shapes, len(tracked), sum(face is not None for _, face in tracked))


def to_even_rate(times: NDArray[np.float64], rows: NDArray[np.float64], /) -> tuple[float, NDArray[np.float64]]:
    """Return frames a second, and rows at that rate; rows that are uneven in time are interpolated linearly.

    times : (N,) seconds, rising; rows : (N, k), what belongs to each time
    """
    steps = np.diff(times)
    if not len(steps):
        return 25.0, rows
    if np.ptp(steps) <= EVEN_S and steps.mean() * MAX_FILE_FPS >= 1:
        return 1 / float(steps.mean()), rows
    fps = min(MAX_FPS, 1 / float(np.median(steps)))
    even = times[0] + np.arange(round((times[-1] - times[0]) * fps) + 1) / fps
    after = np.clip(np.searchsorted(times, even, side="right"), 1, len(times) - 1)
    alpha = ((even - times[after - 1]) / steps[after - 1]).clip(0.0, 1.0)[:, None]
    return fps, np.asarray(rows[after - 1] + alpha * (rows[after] - rows[after - 1]))
