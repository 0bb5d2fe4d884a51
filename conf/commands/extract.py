"""`conf extract`: the motion of a clip as a DPC file."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from conf.errors import CameraError
from conf.face.control_points import CONTROL_POINT_COUNT
from conf.face.formats.dpc import MotionClip, write_dpc
from conf.sender.capture.video import open_clip
from conf.sender.motion.extractor import MotionExtractor
from conf.sender.tracking.canonical_face import read_canonical_face
from conf.sender.tracking.model_files import fetch_models
from conf.sender.tracking.offline import Progress, track_clip


@dataclass(frozen=True)
class ExtractionResult:
    """What came out of a clip."""

    frames: int
    frames_tracked: int
    fps: float
    output: str


def extract(clip: Path, output: Path, on_progress: Progress | None = None) -> ExtractionResult:
    """Track a whole clip and write its motion.

    The clip is gone through once for the landmarks and twice with them: first to find the neutral pose, then, with it
    known from the first frame on, for the motion. A frame without a face repeats the one before.
    Raises CameraError, ModelError, FileFormatError.
    """
    with open_clip(clip) as source:
        size, fps = source.size, source.fps
    tracked = [(frame.timestamp, tracking) for frame, tracking in track_clip(clip, on_progress)]
    if not any(tracking for _, tracking in tracked):
        raise CameraError(f"{clip} shows no face: choose a clip in which one face is well seen")
    extractor = MotionExtractor(read_canonical_face(fetch_models()), size)
    for timestamp, tracking in tracked:
        if tracking is not None:
            extractor.update(tracking, timestamp)
    extractor.restart()
    displacements = np.zeros((len(tracked), CONTROL_POINT_COUNT, 3), np.float32)
    poses = np.zeros((len(tracked), 6))
    for i, (timestamp, tracking) in enumerate(tracked):
        if tracking is not None:
            motion = extractor.update(tracking, timestamp)
            displacements[i], poses[i] = motion.displacements, motion.pose
        elif i:
            displacements[i], poses[i] = displacements[i - 1], poses[i - 1]
    write_dpc(output, MotionClip(fps=fps, units="fapu", displacements=displacements, poses=poses))
    return ExtractionResult(len(tracked), sum(t is not None for _, t in tracked), fps, str(output))
