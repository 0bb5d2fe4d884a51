"""`conf export`: a recorded motion or an emotion as pictures, clips, meshes and motion files."""

from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from conf.animator.builder import FaceBuilder
from conf.animator.face_document import open_subject
from conf.animator.file_export import Export, check_output, export, needs_drawing, parse_fps, parse_size
from conf.animator.motion_clips import emotion_motion, peak
from conf.animator.motion_player import open_recording
from conf.errors import ConfError
from conf.face.animation.action_units import load_expression
from conf.face.animation.idle_motion import IdleMotion
from conf.face.animation.playback import duration_of
from conf.face.animation.timed_expression import Envelope
from conf.face.deformation.face_model import Deformer, FaceModel
from conf.face.formats.dpc import Motion
from conf.render.window.offscreen import OffscreenWindow

EMOTION_FPS = 30.0
SEED = 2007  # of the idle life beside an emotion: the same command writes the same file


@dataclass(frozen=True)
class ExportWish:
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
class Exported:
    """What was written."""

    output: str
    frames: int
    seconds: float
    fps: float


def export_file(wish: ExportWish, on_progress: Callable[[float], None] = lambda share: None) -> Exported:
    """Write one file, `on_progress` is told the share that is done.

    Raises ConfError, FileFormatError, GraphicsError.
    """
    check_output(wish.output)
    size, fps = parse_size(wish.size), None if wish.fps is None else parse_fps(wish.fps)
    subject = open_subject(wish.face, wish.ppc)
    if subject.points is None:
        raise ConfError(f"{subject.path} has no control points: run `conf fit {subject.path}` or give --ppc FILE")
    face = FaceBuilder(subject).build(Deformer())
    motion, strongest = _motion(wish, face, fps)
    at = strongest if wish.at is None else wish.at
    if not 0 <= at <= duration_of(motion):
        raise ConfError(f"the motion lasts {duration_of(motion):.2f} seconds: there is nothing at {at:g}")
    motion_fps = motion.fps if fps is None else fps
    order = Export(wish.output, size, fps, at)
    with ExitStack() as stack:
        ctx = stack.enter_context(OffscreenWindow(1, 1)).ctx if needs_drawing(wish.output) else None
        for share in export(face, motion, order, ctx):
            on_progress(share)
    frames = int(duration_of(motion) * motion_fps + 1e-6) + 1
    return Exported(str(wish.output), frames, duration_of(motion), motion_fps)


def _motion(wish: ExportWish, face: FaceModel, fps: float | None) -> tuple[Motion, float]:
    """Return the motion and the moment to show of it."""
    if wish.dpc is not None:
        return open_recording(wish.dpc, face.fapu).motion, 0.0
    if wish.emotion is None:
        raise ConfError("nothing to export: give --dpc FILE or --emotion NAME")
    expressions = load_expression(wish.emotion).in_fapu(face.fapu)
    envelope, idle = Envelope(), IdleMotion(np.random.default_rng(SEED))
    parts = [emotion_motion(frame, envelope, fps=fps or EMOTION_FPS, idle=idle) for frame in expressions.displacements]
    joined = [np.concatenate([part.displacements for part in parts])]
    poses = np.concatenate([part.poses for part in parts if part.poses is not None])
    return replace(parts[0], displacements=joined[0], poses=poses), peak(envelope)
