"""Write pictures, clips, moved meshes and motion files: by the suffix of the name.

Everything comes as a generator of progress, so that a window can go on drawing while a clip is written picture by
picture.
"""

import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import moderngl
import numpy as np
from numpy.typing import NDArray

from conf.animator.face_view import FaceView
from conf.animator.motion_clips import fit_to_aspect, resample
from conf.animator.motion_player import REST_POSE
from conf.animator.state.view_settings import ViewSettings, with_eye_contact
from conf.errors import ConfError
from conf.face.animation.playback import displacements_at, pose_at
from conf.face.deformation.face_model import FaceModel
from conf.face.formats.dpc import MotionClip, write_dpc
from conf.face.formats.ppc import write_ppc
from conf.face.head_pose import HeadPose
from conf.face.retargeting.arkit_csv import write_blendshape_csv
from conf.face.retargeting.mpeg4_fap import to_faps, write_fap
from conf.output.media_writer import IMAGE_FORMATS, VIDEO_FORMATS, VideoWriter, save_image
from conf.output.obj_writer import write_obj
from conf.render.window.offscreen import read_pixels

SIZE_LIMITS = (16, 4096)  # least and most pixels of a picture's side
FPS_LIMITS = (1.0, 120.0)


@dataclass(frozen=True)
class ExportOptions:
    """What is to be written.

    size : width and height of pictures in pixels
    fps : of clips and motion files; None keeps the motion's
    at : seconds into the motion, for a single picture or mesh
    look : style, view, light
    """

    output: Path
    size: tuple[int, int] = (1280, 720)
    fps: float | None = None
    at: float = 0.0
    look: ViewSettings = field(default_factory=ViewSettings)


def check_output(output: Path, /) -> None:
    """Raise ConfError unless the name's suffix is one that can be written and its folder is there."""
    if output.suffix.lower() not in WRITERS:
        raise ConfError(f"{output}: the name must end in one of {', '.join(WRITERS)}")
    if not output.absolute().parent.is_dir():
        raise ConfError(f"{output} cannot be written: there is no folder {output.absolute().parent}")


def parse_size(text: str, /) -> tuple[int, int]:
    """Read `WxH`. Raises ConfError unless both sides can be drawn."""
    match = re.fullmatch(r"\s*(\d{1,5})\s*[x×]\s*(\d{1,5})\s*", text, re.IGNORECASE)
    low, high = SIZE_LIMITS
    if not match or not all(low <= int(side) <= high for side in match.groups()):
        raise ConfError(f"size must be WIDTHxHEIGHT, {low} to {high} pixels each, such as 1280x720, got {text!r}")
    return int(match[1]), int(match[2])


def parse_fps(text: str, /) -> float:
    """Read pictures a second. Raises ConfError unless it is in RATES."""
    low, high = FPS_LIMITS
    try:
        fps = float(text)
    except ValueError:
        fps = 0.0
    if not low <= fps <= high:
        raise ConfError(f"fps must be {low:g} to {high:g} pictures a second, got {text!r}")
    return fps


def needs_drawing(output: Path, /) -> bool:
    """Tell whether a file is made of pictures."""
    return output.suffix.lower() in (*IMAGE_FORMATS, *VIDEO_FORMATS)


def export(
    face: FaceModel, motion: MotionClip, options: ExportOptions, ctx: moderngl.Context | None = None, /
) -> Iterator[float]:
    """Write one file; yields the share that is done, 1.0 last.

    motion : FAPU units, poses as `player.centred` gives them
    ctx : OpenGL, for pictures and clips
    Raises ConfError if the file cannot be written.
    """
    check_output(options.output)
    writer = WRITERS[options.output.suffix.lower()]
    yield from writer(face, motion, options, ctx)
    yield 1.0


@contextmanager
def frame_renderer(
    face: FaceModel, options: ExportOptions, ctx: moderngl.Context | None
) -> Iterator["OffscreenFrameRenderer"]:
    """Open a camera of the wished size and put it away afterwards."""
    if ctx is None:
        raise ValueError("ctx must be given for pictures and clips")
    camera = OffscreenFrameRenderer(ctx, face, options)
    try:
        yield camera
    finally:
        camera.release()


class OffscreenFrameRenderer:
    """Takes pictures of a face in memory."""

    def __init__(self, ctx: moderngl.Context, face: FaceModel, options: ExportOptions) -> None:
        self._face, self._wish = face, options
        self._picture = FaceView(ctx, face)
        self._colour = ctx.renderbuffer(options.size, 4)
        self._depth = ctx.depth_renderbuffer(options.size)
        self._framebuffer = ctx.framebuffer(self._colour, self._depth)

    def render(self, motion: MotionClip, time: float) -> NDArray[np.uint8]:
        """Return (H, W, 3) uint8 BGR of a motion at a time in seconds."""
        vertices, pose = deform_at(self._face, motion, time, self._wish.look)
        return self.take_vertices(vertices, pose)

    def take_vertices(self, vertices: NDArray[np.float32], pose: HeadPose) -> NDArray[np.uint8]:
        """Return (H, W, 3) uint8 BGR of (V, 3) vertices."""
        self._framebuffer.use()
        self._framebuffer.clear()
        self._picture.draw(vertices, pose, self._wish.look, self._framebuffer)
        return read_pixels(self._framebuffer, self._wish.size)

    def release(self) -> None:
        """Free everything on the card."""
        for thing in (self._picture, self._framebuffer, self._colour, self._depth):
            thing.release()


def deform_at(
    face: FaceModel, motion: MotionClip, time: float, look: ViewSettings, /
) -> tuple[NDArray[np.float32], HeadPose]:
    """Return the (V, 3) vertices and the pose of a motion at a time in seconds."""
    vector = pose_at(motion, time)
    pose = REST_POSE if vector is None else HeadPose.from_vector(vector)
    displacements = displacements_at(motion, time)
    if look.eye_contact:
        displacements = with_eye_contact(displacements, pose, look.view)
    return face.deform(displacements), pose


def _write_picture(
    face: FaceModel, motion: MotionClip, options: ExportOptions, ctx: moderngl.Context | None
) -> Iterator[float]:
    with frame_renderer(face, options, ctx) as camera:
        save_image(options.output, camera.render(fit_to_aspect(_posed(motion), options.size), options.at))
    yield from ()


def _write_clip(
    face: FaceModel, motion: MotionClip, options: ExportOptions, ctx: moderngl.Context | None
) -> Iterator[float]:
    motion = fit_to_aspect(_posed(_at_rate(motion, options)), options.size)
    frames = len(motion.displacements)
    with frame_renderer(face, options, ctx) as camera, VideoWriter(options.output, fps=motion.fps) as recorder:
        for i in range(frames):
            recorder.write(camera.render(motion, i / motion.fps))
            yield (i + 1) / (frames + 1)


def _write_mesh(
    face: FaceModel, motion: MotionClip, options: ExportOptions, _ctx: moderngl.Context | None
) -> Iterator[float]:
    vertices, _ = deform_at(face, motion, options.at, options.look)
    write_obj(options.output, face.mesh, face.to_file_coordinates(vertices))
    yield from ()


def _write_points(
    face: FaceModel, motion: MotionClip, options: ExportOptions, _ctx: moderngl.Context | None
) -> Iterator[float]:
    points = face.deformed_points(displacements_at(motion, options.at))
    write_ppc(options.output, face.to_file_coordinates(points))
    yield from ()


def _motion_writer(write: Callable[[FaceModel, MotionClip, Path], None]) -> "Writer":
    def writer(
        face: FaceModel, motion: MotionClip, options: ExportOptions, _ctx: moderngl.Context | None
    ) -> Iterator[float]:
        try:
            write(face, _at_rate(motion, options), options.output)
        except OSError as error:
            raise ConfError(f"{options.output} cannot be written ({error.strerror}); choose another file") from error
        yield from ()

    return writer


def _at_rate(motion: MotionClip, options: ExportOptions) -> MotionClip:
    return motion if options.fps is None else resample(motion, options.fps)


def _posed(motion: MotionClip) -> MotionClip:
    if motion.poses is not None:
        return motion
    poses = np.tile(REST_POSE.to_vector(), (len(motion.displacements), 1))
    return MotionClip(motion.fps, motion.units, motion.displacements, poses)


Writer = Callable[[FaceModel, MotionClip, ExportOptions, moderngl.Context | None], Iterator[float]]

WRITERS: dict[str, Writer] = {
    **dict.fromkeys(VIDEO_FORMATS, _write_clip),
    **dict.fromkeys(IMAGE_FORMATS, _write_picture),
    ".obj": _write_mesh,
    ".ppc": _write_points,
    ".dpc": _motion_writer(lambda _face, motion, path: write_dpc(path, motion)),
    ".fap": _motion_writer(lambda face, motion, path: write_fap(path, to_faps(motion, face.fapu))),
    ".csv": _motion_writer(lambda _face, motion, path: write_blendshape_csv(path, motion)),
}
