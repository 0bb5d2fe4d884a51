"""`conf export`: a recorded motion or an emotion as pictures, clips, meshes and motion files."""

from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from conf.animator.face_document import open_face_document
from conf.animator.file_export import ExportOptions, check_output, export, needs_drawing, parse_fps, parse_size
from conf.animator.motion_clips import make_expression_clip, peak_time
from conf.animator.motion_player import load_motion_clip
from conf.errors import ConfError
from conf.face.animation.action_units import load_expression
from conf.face.animation.idle_motion import IdleMotion
from conf.face.animation.playback import duration_of
from conf.face.animation.timed_expression import Envelope
from conf.face.deformation.face_model import DeformerOptions, FaceModel
from conf.face.formats.dpc import MotionClip
from conf.render.window.offscreen import OffscreenWindow

EMOTION_FPS = 30.0
SEED = 2007  # of the idle life beside an emotion: the same command writes the same file


@dataclass(frozen=True)
class ExportRequest:
    """What the command line asks for: one of dpc and emotion is given.

    size : `WxH`; fps : pictures a second; both as typed
    face, ppc : another face than the shipped head
    at : seconds, of a single picture or mesh; None takes an emotion at its strongest, a recording at its beginning
    """

    output: Path
    dpc: Path | None = None
    emotion: str | None = None
    size: str = "1280x720"
    fps: str | None = None
    face: Path | None = None
    ppc: Path | None = None
    at: float | None = None


@dataclass(frozen=True)
class ExportResult:
    """What was written."""

    output: str
    frames: int
    seconds: float
    fps: float


def export_file(request: ExportRequest, on_progress: Callable[[float], None] = lambda share: None) -> ExportResult:
    """Write one file, `on_progress` is told the share that is done.

    Raises ConfError, FileFormatError, GraphicsError.
    """
    check_output(request.output)
    size, fps = parse_size(request.size), None if request.fps is None else parse_fps(request.fps)
    subject = open_face_document(request.face, request.ppc)
    if subject.points is None:
        raise ConfError(f"{subject.path} has no control points: run `conf fit {subject.path}` or give --ppc FILE")
    face = subject.operator_builder().build_face(DeformerOptions())
    motion, peak_time = _motion(request, face, fps)
    at = peak_time if request.at is None else request.at
    if not 0 <= at <= duration_of(motion):
        raise ConfError(f"the motion lasts {duration_of(motion):.2f} seconds: there is nothing at {at:g}")
    motion_fps = motion.fps if fps is None else fps
    order = ExportOptions(request.output, size, fps, at)
    with ExitStack() as stack:
        ctx = stack.enter_context(OffscreenWindow(1, 1)).ctx if needs_drawing(request.output) else None
        for share in export(face, motion, order, ctx):
            on_progress(share)
    frames = int(duration_of(motion) * motion_fps + 1e-6) + 1
    return ExportResult(str(request.output), frames, duration_of(motion), motion_fps)


def _motion(request: ExportRequest, face: FaceModel, fps: float | None) -> tuple[MotionClip, float]:
    """Return the motion and the moment to show of it."""
    if request.dpc is not None:
        return load_motion_clip(request.dpc, face.fapu).motion, 0.0
    if request.emotion is None:
        raise ConfError("nothing to export: give --dpc FILE or --emotion NAME")
    expressions = load_expression(request.emotion).in_fapu(face.fapu)
    envelope, idle = Envelope(), IdleMotion(np.random.default_rng(SEED))
    parts = [
        make_expression_clip(frame, envelope, fps=fps or EMOTION_FPS, idle=idle) for frame in expressions.displacements
    ]
    joined = [np.concatenate([part.displacements for part in parts])]
    poses = np.concatenate([part.poses for part in parts if part.poses is not None])
    return replace(parts[0], displacements=joined[0], poses=poses), peak_time(envelope)
