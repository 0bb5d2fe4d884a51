"""`conf extract`: write the motion of a clip as a DPC file."""

import argparse
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from conf.commands import Terminal
from conf.commands.arguments import add_json
from conf.errors import CameraError

HELP = "write the motion of a clip as a DPC file"


@dataclass(frozen=True)
class ExtractionResult:
    """The figures of an extraction."""

    frames: int
    frames_tracked: int
    fps: float
    output: str


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("clip", type=Path)
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="OUT.dpc")
    add_json(parser)


def run(options: argparse.Namespace, terminal: Terminal) -> None:
    with terminal.status_line() as show:
        result = extract(options.clip, options.output, on_progress=lambda count: show(f"{count} frames"))
    terminal.print_figures("extracted", result)


def extract(clip: Path, output: Path, on_progress: Callable[[int], None] | None = None) -> ExtractionResult:
    """Track a clip and write its motion.

    The landmarks are extracted once and filtered twice: first to find the neutral pose, then to compute the motion with
    that pose known from the first frame on. A frame without a face repeats the one before.
    Raises CameraError, ModelError, FileFormatError.
    """
    import numpy as np

    from conf.face.control_points import CONTROL_POINT_COUNT
    from conf.face.formats.dpc import MotionClip, write_dpc
    from conf.sender.capture.clip import open_clip
    from conf.sender.motion.extractor import MotionExtractor
    from conf.sender.tracking.canonical_face import load_canonical_face
    from conf.sender.tracking.offline import track_clip

    with open_clip(clip) as source:
        size, fps = source.size, source.fps
    tracked = [(frame.timestamp, tracking) for frame, tracking in track_clip(clip, on_progress)]
    if not any(tracking for _, tracking in tracked):
        raise CameraError(f"{clip} shows no face: choose a clip in which one face is clearly visible")
    extractor = MotionExtractor(load_canonical_face(), size)
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
