"""`conf extract`: write the motion of a clip as a DPC file."""

import argparse
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from conf.atomic_write import check_writable, report_write_errors
from conf.commands import Terminal
from conf.commands.support.arguments import add_json
from conf.errors import RecordingError

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
        result = extract(
            options.clip,
            options.output,
            on_progress=lambda *counts: show(progress_text(*counts)),
            on_note=terminal.write,
        )
    terminal.print_figures("extracted", result)


def progress_text(frames: int, faces: int) -> str:
    """Return what to show while a clip is tracked."""
    return f"{frames} frames" if faces else f"{frames} frames, no face found yet"


def extract(
    clip: Path,
    output: Path,
    *,
    on_progress: Callable[[int, int], None] | None = None,
    on_note: Callable[[str], None] = lambda text: None,
) -> ExtractionResult:
    """Track a clip and write its motion; on_note gets what was odd about the clip.

    Raises CameraError, ModelError, RecordingError.
    """
    from conf.face.formats.dpc import write_dpc
    from conf.sender.tracking.offline import extract_motion

    check_writable(output)
    extracted = extract_motion(clip, on_progress, on_note)
    with report_write_errors(output, RecordingError):
        write_dpc(output, extracted.motion)
    return ExtractionResult(extracted.frames, extracted.frames_tracked, extracted.motion.fps, str(output.absolute()))
