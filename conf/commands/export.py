"""`conf export`: write a recorded motion or an emotion as an image, clip, mesh or motion file."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING

from conf.commands import Terminal
from conf.commands.support.arguments import add_json
from conf.errors import ConfError

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from conf.face.deformation.face_model import FaceModel
    from conf.face.formats.dpc import MotionClip

HELP = "write a recording or an emotion as an image, clip or other format"
EMOTION_FPS = 30.0


@dataclass(frozen=True)
class ExportRequest:
    """What to export; exactly one of dpc and emotion is given.

    size : `WxH`; fps : frames a second; both as typed
    face, ppc : another face than the shipped head
    at : seconds, of a single image or mesh; None is the peak of an emotion, the start of a recording
    sound : a file with sound for a clip
    """

    output: Path
    dpc: Path | None = None
    emotion: str | None = None
    size: str = "1280x720"
    fps: str | None = None
    face: Path | None = None
    ppc: Path | None = None
    at: float | None = None
    sound: Path | None = None


@dataclass(frozen=True)
class ExportResult:
    """The figures of a written file."""

    output: str
    frames: int
    seconds: float
    fps: float


def add_arguments(parser: argparse.ArgumentParser) -> None:
    source = parser.add_mutually_exclusive_group(required=True)
    source.add_argument("--dpc", type=Path, help="a recording")
    source.add_argument("--emotion", metavar="NAME", help="an emotion, or an EPC file")
    suffixes = "a .jpg .png .mp4 .avi .obj .dpc .fap or .csv file"
    parser.add_argument("-o", "--output", type=Path, required=True, help=suffixes)
    parser.add_argument(
        "--size",
        default=ExportRequest.size,
        metavar="WxH",
        help=f"pixels of an image or clip (default {ExportRequest.size})",
    )
    parser.add_argument("--fps", metavar="N", help="frames a second")
    parser.add_argument("--face", type=Path, metavar="FILE", help="another face: a mesh with its PPC beside it")
    parser.add_argument("--ppc", type=Path, help="its control points, if they are elsewhere")
    parser.add_argument("--sound", type=Path, metavar="FILE", help="sound for a clip, from its start")
    parser.add_argument("--at", type=float, metavar="S", help="the time of a single image or mesh, in seconds")
    add_json(parser)


def run(options: argparse.Namespace, terminal: Terminal) -> None:
    request = ExportRequest(**{field.name: getattr(options, field.name) for field in fields(ExportRequest)})
    with terminal.progress_bar() as show:
        result = export_file(request, show, terminal.write)
    terminal.print_figures("exported", result)


def export_file(
    request: ExportRequest,
    on_progress: Callable[[float], None] = lambda fraction: None,
    on_note: Callable[[str], None] = lambda text: None,
) -> ExportResult:
    """Write one file; on_progress gets the fraction that is done, on_note what was wrong with the mesh's file.

    Raises ConfError, FileFormatError, GraphicsError.
    """
    from conf.animator import file_export
    from conf.animator.face_document import open_face_document
    from conf.face.animation.playback import duration_of
    from conf.face.deformation.face_model import DeformerOptions
    from conf.render.window.offscreen import OffscreenWindow

    file_export.check_output(request.output)
    size = file_export.parse_size(request.size)
    fps = None if request.fps is None else file_export.parse_fps(request.fps)
    subject = open_face_document(request.face, request.ppc)
    if subject.points is None:
        raise ConfError(f"{subject.path} has no control points: run `conf fit {subject.path}` or give --ppc FILE")
    if subject.source.notes:
        on_note(f"{subject.path}: {'; '.join(subject.source.notes)}")
    face = subject.operator_builder().build_face(DeformerOptions())
    motion, default_time = _load_motion(request, face, fps)
    seconds, at = duration_of(motion), default_time if request.at is None else request.at
    if not 0 <= at <= seconds:
        raise ConfError(f"the motion lasts {seconds:.2f} seconds: choose a time --at up to that instead of {at:g}")
    sound = None if request.sound is None else _load_sound(request.sound, request.output)
    options = file_export.ExportOptions(request.output, size, fps, at, sound=sound)
    with ExitStack() as stack:
        draws = file_export.needs_drawing(request.output)
        ctx = stack.enter_context(OffscreenWindow(1, 1)).ctx if draws else None
        for fraction in file_export.export(face, motion, options, ctx):
            on_progress(fraction)
    motion_fps = motion.fps if fps is None else fps
    return ExportResult(str(request.output.absolute()), int(seconds * motion_fps + 1e-6) + 1, seconds, motion_fps)


def _load_motion(request: ExportRequest, face: FaceModel, fps: float | None) -> tuple[MotionClip, float]:
    """Return the motion, and the time in seconds that a single image shows."""
    from conf.animator.motion_player import load_motion_clip, make_expression_clip, peak_time
    from conf.face.animation.action_units import load_expression
    from conf.face.animation.timed_expression import Envelope

    if request.dpc is not None:
        return load_motion_clip(request.dpc, face.fapu), 0.0
    if request.emotion is None:
        raise ConfError("nothing to export: give --dpc FILE or --emotion NAME")
    expressions = load_expression(request.emotion).in_fapu(face.fapu).displacements
    clip = make_expression_clip(expressions, Envelope(), fps=fps or EMOTION_FPS, idle=True)
    return clip, peak_time(Envelope())


def _load_sound(path: Path, output: Path) -> NDArray[np.int16]:
    """Return the sound for a clip. Raises ConfError if the output is no clip or the file has no sound."""
    import numpy as np

    from conf.animator.file_export import SOUND_RATE
    from conf.output.clip_encoder import CLIP_FORMATS
    from conf.sender.capture.clip import read_sound

    if output.suffix.lower() not in CLIP_FORMATS:
        raise ConfError(f"{output.name} holds no sound: give a clip ({' '.join(CLIP_FORMATS)}), or leave --sound out")
    blocks = [samples for _, samples in read_sound(path, rate=SOUND_RATE)]
    if not blocks:
        raise ConfError(f"{path} has no sound: give a file with a sound track")
    return np.concatenate(blocks)
