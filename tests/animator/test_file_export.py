import itertools
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import cv2
import moderngl
import numpy as np
import pytest

from conf.animator.face_document import FaceDocument
from conf.animator.file_export import ExportOptions, check_output, export, needs_drawing, parse_fps, parse_size
from conf.animator.motion_player import make_expression_clip
from conf.animator.state.editor import ViewSettings
from conf.errors import ConfError
from conf.face.animation.action_units import load_emotions
from conf.face.animation.timed_expression import Envelope
from conf.face.deformation.face_model import FaceModel
from conf.face.formats.dpc import MotionClip, read_dpc
from conf.face.formats.ppc import read_ppc
from conf.face.mesh.mesh import load_mesh
from conf.face.similarity import SimilarityTransform
from conf.render.window.offscreen import OffscreenWindow


@pytest.fixture(scope="module")
def clip() -> MotionClip:
    return make_expression_clip([load_emotions()["surprise"]], Envelope(0.2, 0.2, 0.2), fps=15.0, idle=False)


@pytest.fixture
def ctx(gl: None) -> Iterator[moderngl.Context]:
    with OffscreenWindow(1, 1) as window:
        yield window.ctx


def write(
    face: FaceModel, clip: MotionClip, options: ExportOptions, ctx: moderngl.Context | None = None
) -> list[float]:
    """Export a file. Returns the progress values."""
    progress = list(export(face, clip, options, ctx))
    assert progress == sorted(progress) and progress[-1] == 1.0
    return progress


@pytest.mark.slow
def test_motion_files_are_read_back(tmp_path: Path, head: FaceModel, clip: MotionClip) -> None:
    write(head, clip, ExportOptions(tmp_path / "a.dpc", fps=30.0))
    assert read_dpc(tmp_path / "a.dpc").fps == 30.0
    write(head, clip, ExportOptions(tmp_path / "a.fap"))
    header = (tmp_path / "a.fap").read_text(encoding="utf-8").splitlines()[0]
    assert header.startswith("2.1 conf") and header.endswith(f" {len(clip.displacements)}")
    write(head, clip, ExportOptions(tmp_path / "a.csv"))
    lines = (tmp_path / "a.csv").read_text(encoding="utf-8").splitlines()
    assert len(lines) == len(clip.displacements) + 1 and lines[0].startswith("Timecode,BlendShapeCount,EyeBlinkLeft")


@pytest.mark.slow
def test_a_deformed_mesh_and_its_points_are_read_back(
    tmp_path: Path, head: FaceModel, document: FaceDocument, clip: MotionClip
) -> None:
    scaled = replace(head, file_to_model=SimilarityTransform(np.eye(3), 0.1, np.zeros(3)))
    write(scaled, clip, ExportOptions(tmp_path / "a.obj", at=0.6))
    mesh = load_mesh(tmp_path / "a.obj")
    np.testing.assert_allclose(mesh.vertices / 10, head.deform(load_emotions()["surprise"]), atol=0.05)
    assert mesh.groups.keys() == document.mesh.groups.keys() and len(mesh.uvs) == len(document.mesh.uvs)
    np.testing.assert_array_equal(mesh.triangles, document.mesh.triangles)
    write(head, clip, ExportOptions(tmp_path / "a.ppc", at=0.0))
    np.testing.assert_allclose(read_ppc(tmp_path / "a.ppc"), head.control_points, atol=1e-5)


@pytest.mark.slow
@pytest.mark.parametrize(("name", "size"), [("a.avi", (96, 64)), ("a.mp4", (97, 65))])
def test_a_clip_has_its_size_rate_and_length(
    tmp_path: Path, head: FaceModel, clip: MotionClip, ctx: moderngl.Context, name: str, size: tuple[int, int]
) -> None:
    progress = write(head, clip, ExportOptions(tmp_path / name, size, 10.0), ctx)
    video = cv2.VideoCapture(str(tmp_path / name))
    assert video.get(cv2.CAP_PROP_FPS) == pytest.approx(10.0)
    frames = 0
    while (read := video.read())[0]:
        assert read[1].shape[:2][::-1] in (size, (size[0] + size[0] % 2, size[1] + size[1] % 2))
        frames += 1
    assert frames == 13 and len(progress) == frames + 1


@pytest.mark.slow
def test_images_show_style_lights_and_background(
    tmp_path: Path, head: FaceModel, clip: MotionClip, ctx: moderngl.Context
) -> None:
    views = {
        "plain": ViewSettings(),
        "wireframe": ViewSettings(style="wireframe"),
        "regions": ViewSettings(style="regions"),
        "green": ViewSettings(background="green"),
        **{name: ViewSettings(lights=name) for name in ("evening", "dramatic")},
    }
    images = {}
    for name, view in views.items():
        write(head, clip, ExportOptions(tmp_path / f"{name}.png", (80, 80), at=0.6, view=view), ctx)
        images[name] = np.asarray(cv2.imread(str(tmp_path / f"{name}.png"))).astype(int)
    for one, other in itertools.combinations(images, 2):
        assert np.abs(images[one] - images[other]).max(axis=2).mean() > 5, (one, other)
    assert images["green"][2, 2].tolist() == [64, 177, 0]
    assert images["evening"][40, 40, 2] > images["evening"][40, 40, 0]


def test_images_and_clips_need_a_context(tmp_path: Path, head: FaceModel, clip: MotionClip) -> None:
    assert [needs_drawing(Path(name)) for name in ("a.jpg", "a.MP4", "a.obj", "a.dpc")] == [True, True, False, False]
    with pytest.raises(ValueError, match="ctx must be given for images and clips"):
        write(head, clip, ExportOptions(tmp_path / "a.png"))


def test_unknown_formats_and_folders_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ConfError, match=r"a\.gif: the name must end in one of \.mp4, \.avi, "):
        check_output(tmp_path / "a.gif")
    with pytest.raises(ConfError, match=r"nowhere.* cannot be written \(No such file or directory\); choose another"):
        check_output(tmp_path / "nowhere" / "a.avi")


@pytest.mark.slow
@pytest.mark.parametrize("suffix", [".obj", ".ppc", ".dpc", ".fap", ".csv"])
def test_a_file_that_cannot_be_written_is_reported(
    tmp_path: Path, head: FaceModel, clip: MotionClip, suffix: str
) -> None:
    path = tmp_path / f"a{suffix}"
    path.mkdir()
    with pytest.raises(ConfError, match=r"a\.\w+ cannot be written \(Is a directory\)"):
        write(head, clip, ExportOptions(path))


@pytest.mark.parametrize("text", ["", "640", "0x480", "640x99999", "axb", "-1x5"])
def test_an_invalid_size_is_refused(text: str) -> None:
    with pytest.raises(ConfError, match="size must be WIDTHxHEIGHT, 16 to 4096 pixels each"):
        parse_size(text)


@pytest.mark.parametrize("text", ["", "0", "nan", "1000", "fast"])
def test_an_invalid_frame_rate_is_refused(text: str) -> None:
    with pytest.raises(ConfError, match="fps must be 1 to 120 frames per second"):
        parse_fps(text)


def test_sizes_and_frame_rates_are_parsed() -> None:
    assert parse_size(" 640X480 ") == (640, 480)
    assert parse_fps("29.97") == pytest.approx(29.97)
