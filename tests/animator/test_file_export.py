from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import cv2
import moderngl
import numpy as np
import pytest

from conf.animator.face_document import FaceDocument
from conf.animator.file_export import ExportOptions, check_output, export, parse_fps, parse_size
from conf.animator.motion_clips import make_expression_clip
from conf.animator.state.view_settings import ViewSettings
from conf.errors import ConfError
from conf.face.animation.action_units import load_emotions
from conf.face.animation.timed_expression import Envelope
from conf.face.deformation.face_model import FaceModel
from conf.face.formats.dpc import MotionClip, read_dpc
from conf.face.formats.ppc import read_ppc
from conf.face.mesh.mesh import load_mesh
from conf.face.retargeting.mpeg4_fap import read_fap
from conf.face.similarity import SimilarityTransform
from conf.render.lighting import LIGHTS
from conf.render.window.offscreen import OffscreenWindow


@pytest.fixture(scope="module")
def motion() -> MotionClip:
    return make_expression_clip(load_emotions()["surprise"], Envelope(0.2, 0.2, 0.2), fps=15.0)


@pytest.fixture
def ctx(gl: None) -> Iterator[moderngl.Context]:
    with OffscreenWindow(1, 1) as window:
        yield window.ctx


def write(face: FaceModel, motion: MotionClip, wish: ExportOptions, ctx: moderngl.Context | None = None) -> list[float]:
    shares = list(export(face, motion, wish, ctx))
    assert shares == sorted(shares) and shares[-1] == 1.0
    return shares


def test_motion_files_are_read_back(tmp_path: Path, head: FaceModel, motion: MotionClip) -> None:
    write(head, motion, ExportOptions(tmp_path / "a.dpc", fps=30.0))
    assert read_dpc(tmp_path / "a.dpc").fps == 30.0
    write(head, motion, ExportOptions(tmp_path / "a.fap"))
    assert len(read_fap(tmp_path / "a.fap").values) == len(motion.displacements)
    write(head, motion, ExportOptions(tmp_path / "a.csv"))
    table = (tmp_path / "a.csv").read_text(encoding="utf-8").splitlines()
    assert len(table) == len(motion.displacements) + 1 and table[0].startswith("Timecode,BlendShapeCount,EyeBlinkLeft")


def test_a_moved_mesh_and_its_points_are_read_back(
    tmp_path: Path, head: FaceModel, subject: FaceDocument, motion: MotionClip
) -> None:
    small = replace(head, file_to_model=SimilarityTransform(np.eye(3), 0.1, np.zeros(3)))
    write(small, motion, ExportOptions(tmp_path / "a.obj", at=0.6))
    mesh = load_mesh(tmp_path / "a.obj")
    moved = head.deform(load_emotions()["surprise"])
    np.testing.assert_allclose(mesh.vertices / 10, moved, atol=0.05)
    assert mesh.groups.keys() == subject.mesh.groups.keys() and len(mesh.uvs) == len(subject.mesh.uvs)
    np.testing.assert_array_equal(mesh.triangles, subject.mesh.triangles)
    write(head, motion, ExportOptions(tmp_path / "a.ppc", at=0.0))
    np.testing.assert_allclose(read_ppc(tmp_path / "a.ppc"), head.control_points, atol=1e-5)


@pytest.mark.parametrize(("name", "size"), [("a.avi", (96, 64)), ("a.mp4", (97, 65))])
def test_a_clip_has_its_size_rate_and_length(
    tmp_path: Path, head: FaceModel, motion: MotionClip, ctx: moderngl.Context, name: str, size: tuple[int, int]
) -> None:
    shares = write(head, motion, ExportOptions(tmp_path / name, size, 10.0), ctx)
    clip = cv2.VideoCapture(str(tmp_path / name))
    assert clip.get(cv2.CAP_PROP_FPS) == pytest.approx(10.0)
    frames = 0
    while (read := clip.read())[0]:
        assert read[1].shape[:2][::-1] in (size, (size[0] // 2 * 2, size[1] // 2 * 2))
        frames += 1
    assert frames == 13 and len(shares) == frames + 1


def test_pictures_show_style_and_light(
    tmp_path: Path, head: FaceModel, motion: MotionClip, ctx: moderngl.Context
) -> None:
    looks = {
        "plain": ViewSettings(),
        "wire": ViewSettings(style="wireframe"),
        "regions": ViewSettings(style="regions"),
        "green": ViewSettings(background="green"),
        **{name: ViewSettings(lights=name) for name in ("evening", "dramatic")},
    }
    pictures = {}
    for name, look in looks.items():
        write(head, motion, ExportOptions(tmp_path / f"{name}.png", (80, 80), at=0.6, look=look), ctx)
        pictures[name] = np.asarray(cv2.imread(str(tmp_path / f"{name}.png"))).astype(int)
    names = list(pictures)
    for i, one in enumerate(names):
        for other in names[i + 1 :]:
            assert np.abs(pictures[one] - pictures[other]).max(axis=2).mean() > 5, (one, other)
    assert pictures["green"][2, 2].tolist() == [64, 177, 0]
    assert pictures["evening"][40, 40, 2] > pictures["evening"][40, 40, 0]
    assert "studio" in LIGHTS


def test_what_cannot_be_written_is_said_before_any_work(tmp_path: Path) -> None:
    with pytest.raises(ConfError, match=r"a\.gif: the name must end in one of \.avi, \.mp4, "):
        check_output(tmp_path / "a.gif")
    with pytest.raises(ConfError, match=r"cannot be written: there is no folder .*nowhere"):
        check_output(tmp_path / "nowhere" / "a.avi")


@pytest.mark.parametrize("text", ["", "640", "0x480", "640x99999", "axb", "-1x5"])
def test_a_size_that_cannot_be_drawn_is_refused(text: str) -> None:
    with pytest.raises(ConfError, match="size must be WIDTHxHEIGHT, 16 to 4096 pixels each"):
        parse_size(text)


@pytest.mark.parametrize("text", ["", "0", "nan", "1000", "fast"])
def test_a_rate_that_makes_no_sense_is_refused(text: str) -> None:
    with pytest.raises(ConfError, match="fps must be 1 to 120 pictures a second"):
        parse_fps(text)


def test_sizes_and_rates_are_read() -> None:
    assert parse_size(" 640X480 ") == (640, 480)
    assert parse_fps("29.97") == pytest.approx(29.97)
