"""`conf extract`: write the motion of a clip as a DPC file, or as ARKit blendshape weights."""

import argparse
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from conf.atomic_write import check_writable, report_write_errors
from conf.commands import Terminal
from conf.commands.support.arguments import add_json
from conf.errors import RecordingError

OUTPUT_HELP = "control points as .dpc, or the tracker's own ARKit blendshape weights as .csv"
HELP = "write the motion of a clip as a DPC or CSV file"


@dataclass(frozen=True)
class ExtractionResult:
    """The figures of an extraction."""

    frames: int
    frames_tracked: int
    fps: float
    output: str


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("clip", type=Path, help="any clip with a face")
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="OUT.dpc", help=OUTPUT_HELP)
    parser.add_argument("--sound", type=Path, metavar="OUT.wav", help="write the clip's sound to a file, too")
    add_json(parser)


def run(options: argparse.Namespace, terminal: Terminal) -> None:
    with terminal.status_line() as show:
        result = extract(
            options.clip,
            options.output,
            sound=options.sound,
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
    sound: Path | None = None,
    on_progress: Callable[[int, int], None] | None = None,
    on_note: Callable[[str], None] = lambda text: None,
) -> ExtractionResult:
    """Track a clip and write its motion; on_note gets what was odd about the clip.

    output : .csv holds the tracker's own blendshape weights, any other name the control points as DPC
    sound : WAV file for the clip's sound, None to write none
    Raises CameraError, ModelError, RecordingError.
    """
    import numpy as np

    from conf.face.formats.dpc import write_dpc
    from conf.face.retargeting.arkit_csv import write_blendshape_csv
    from conf.output.wav_writer import write_wav
    from conf.sender.capture.clip import SOUND_RATE
    from conf.sender.capture.sound import record_sound
    from conf.sender.tracking.blendshape_network import to_arkit_order
    from conf.sender.tracking.offline import extract_motion

    for path in (output, sound):
        if path is not None:
            check_writable(path)
    recorded = None if sound is None else record_sound(clip)
    extracted = extract_motion(clip, on_progress, on_note)
    with report_write_errors(output, RecordingError):
        if output.suffix.lower() == ".csv":
            write_blendshape_csv(output, extracted.motion, weights=to_arkit_order(extracted.shapes))
        else:
            write_dpc(output, extracted.motion)
    if sound is not None and recorded is not None:
        count = round(len(extracted.motion.displacements) / extracted.motion.fps * SOUND_RATE)
        write_wav(sound, np.concatenate([recorded, np.zeros(max(0, count - len(recorded)), np.int16)])[:count])
    return ExtractionResult(extracted.frames, extracted.frames_tracked, extracted.motion.fps, str(output.absolute()))
