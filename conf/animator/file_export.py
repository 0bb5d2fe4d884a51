"""Export images, clips, deformed meshes, control points and motion files; the suffix of the name selects the format."""

import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import moderngl
import numpy as np
from numpy.typing import NDArray

from conf.animator.face_view import FaceView
from conf.animator.motion_mixer import with_eye_contact
from conf.animator.motion_player import MotionSample, fit_to_aspect, resample, sample_clip
from conf.animator.state.editor import ViewSettings
from conf.atomic_write import check_writable, report_write_errors
from conf.errors import ConfError
from conf.face.deformation.face_model import FaceModel
from conf.face.formats.dpc import MotionClip, write_dpc
from conf.face.formats.ppc import write_ppc
from conf.face.head_pose import HeadPose
from conf.face.retargeting.arkit_csv import write_blendshape_csv
from conf.face.retargeting.mpeg4_fap import to_faps, write_fap
from conf.output.clip_encoder import CLIP_FORMATS
from conf.output.image_writer import IMAGE_FORMATS, save_image
from conf.output.obj_writer import write_obj
from conf.output.video_writer import VideoWriter
from conf.render.window import read_pixels

SOUND_RATE = 48000  # samples a second
SIZE_LIMITS = (16, 4096)  # width and height of an image, pixels
FPS_LIMITS = (1.0, 120.0)

STILLS = (*IMAGE_FORMATS, ".obj", ".ppc")  # formats that hold the face at one time
MOTIONS: dict[str, Callable[[FaceModel, MotionClip, Path], None]] = {
    ".dpc": lambda _face, clip, path: write_dpc(path, clip),
    ".fap": lambda face, clip, path: write_fap(path, to_faps(clip, face.fapu)),
    ".csv": lambda _face, clip, path: write_blendshape_csv(path, clip),
}
SUFFIXES = (*CLIP_FORMATS, *STILLS, *MOTIONS)


@dataclass(frozen=True)
class ExportOptions:
    """What to export.

    size : width and height of images and clips, pixels
    fps : of clips and motion files, None for that of the motion
    at : seconds into the motion, for images, meshes and control points
    sound : (n,) int16 mono samples, SOUND_RATE a second, for a clip; None for a silent one
    """

    output: Path
    size: tuple[int, int] = (1280, 720)
    fps: float | None = None
    at: float = 0.0
    view: ViewSettings = field(default_factory=ViewSettings)
    sound: NDArray[np.int16] | None = None


def check_output(output: Path, /) -> None:
    """Raise ConfError unless the suffix is known and the file can be written."""
    if output.suffix.lower() not in SUFFIXES:
        raise ConfError(f"{output}: the name must end in one of {', '.join(SUFFIXES)}")
    check_writable(output)


def parse_size(text: str, /) -> tuple[int, int]:
    """Parse `WxH`. Raises ConfError unless both are within SIZE_LIMITS."""
    match = re.fullmatch(r"\s*(\d{1,5})\s*[x×]\s*(\d{1,5})\s*", text, re.IGNORECASE)
    low, high = SIZE_LIMITS
    if not match or not all(low <= int(side) <= high for side in match.groups()):
        raise ConfError(f"size must be WIDTHxHEIGHT, {low} to {high} pixels each, such as 1280x720, got {text!r}")
    return int(match[1]), int(match[2])


def parse_fps(text: str, /) -> float:
    """Parse a frame rate. Raises ConfError unless it is within FPS_LIMITS."""
    low, high = FPS_LIMITS
    try:
        fps = float(text)
    except ValueError:
        fps = 0.0
    if not low <= fps <= high:
        raise ConfError(f"fps must be {low:g} to {high:g} frames per second, got {text!r}")
    return fps


def needs_drawing(output: Path, /) -> bool:
    """Tell whether the format is an image or a clip."""
    return output.suffix.lower() in (*IMAGE_FORMATS, *CLIP_FORMATS)


def export(
    face: FaceModel, clip: MotionClip, options: ExportOptions, ctx: moderngl.Context | None = None, /
) -> Iterator[float]:
    """Write one file; yield the progress after each frame, 1.0 last, so that a window can draw in between.

    clip : FAPU units, poses as `recentre` returns them
    ctx : needed for images and clips
    Raises ConfError if the file cannot be written.
    """
    check_output(options.output)
    suffix = options.output.suffix.lower()
    if suffix in STILLS:
        sample = _sample(fit_to_aspect(clip, options.size), options.at, options.view)
        export_still(face, face.deform(sample.displacements), sample, options, ctx)
    else:
        clip = clip if options.fps is None else resample(clip, options.fps)
        if suffix in CLIP_FORMATS:
            yield from _write_clip(face, fit_to_aspect(clip, options.size), options, ctx)
        else:
            with report_write_errors(options.output):
                MOTIONS[suffix](face, clip, options.output)
    yield 1.0


def export_still(
    face: FaceModel,
    vertices: NDArray[np.float32],
    sample: MotionSample,
    options: ExportOptions,
    ctx: moderngl.Context | None,
    /,
) -> None:
    """Write the face at one time as an image, a mesh or control points.

    vertices : (V, 3) face axes, cm
    Raises ConfError if the format needs a motion or the file cannot be written.
    """
    suffix = options.output.suffix.lower()
    if suffix not in STILLS:
        kind = "clips" if suffix in CLIP_FORMATS else "motion files"
        raise ConfError(f"{kind} need a motion: choose a recording or an emotion as the source")
    with report_write_errors(options.output):
        if suffix == ".obj":
            write_obj(options.output, face.mesh, face.to_file_coordinates(vertices))
        elif suffix == ".ppc":
            write_ppc(options.output, face.to_file_coordinates(face.deformed_points(sample.displacements)))
        else:
            with _offscreen_renderer(face, options, ctx) as render:
                save_image(options.output, render(vertices, sample.pose))


def _write_clip(
    face: FaceModel, clip: MotionClip, options: ExportOptions, ctx: moderngl.Context | None
) -> Iterator[float]:
    frames = len(clip.displacements)
    rate = None if options.sound is None else SOUND_RATE
    with (
        _offscreen_renderer(face, options, ctx) as render,
        VideoWriter(options.output, fps=clip.fps, audio_rate=rate) as writer,
    ):
        for i in range(frames):
            sample = _sample(clip, i / clip.fps, options.view)
            writer.write(render(face.deform(sample.displacements), sample.pose))
            if options.sound is not None:
                begin, end = (round(frame / clip.fps * SOUND_RATE) for frame in (i, i + 1))
                writer.write_audio(options.sound[begin:end], begin / SOUND_RATE)
            yield (i + 1) / (frames + 1)


@contextmanager
def _offscreen_renderer(
    face: FaceModel, options: ExportOptions, ctx: moderngl.Context | None
) -> Iterator[Callable[[NDArray[np.float32], HeadPose], NDArray[np.uint8]]]:
    """Provide a function that draws (V, 3) vertices in a pose and returns (H, W, 3) uint8 BGR."""
    if ctx is None:
        raise ValueError("ctx must be given for images and clips")
    view = FaceView(ctx, face)
    colour, depth = ctx.renderbuffer(options.size, 4), ctx.depth_renderbuffer(options.size)
    framebuffer = ctx.framebuffer(colour, depth)

    def render(vertices: NDArray[np.float32], pose: HeadPose) -> NDArray[np.uint8]:
        framebuffer.use()
        framebuffer.clear()
        view.draw(vertices, pose, options.view, framebuffer)
        return read_pixels(framebuffer, options.size)

    try:
        yield render
    finally:
        for resource in (view, framebuffer, colour, depth):
            resource.release()


def _sample(clip: MotionClip, position: float, view: ViewSettings) -> MotionSample:
    sample = sample_clip(clip, position)
    return with_eye_contact(sample, view.camera) if view.eye_contact else sample
