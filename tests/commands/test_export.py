from pathlib import Path

import numpy as np
import pytest

from conf.commands.export import ExportRequest, export_file
from conf.errors import ConfError
from conf.face.default_head import DEFAULT_HEAD
from conf.face.formats.dpc import MotionClip, read_dpc, write_dpc
from conf.face.mesh.mesh import load_mesh


@pytest.fixture
def recording(tmp_path: Path) -> Path:
    values = np.zeros((21, 50, 3), np.float32)
    values[:, :, 1] = np.linspace(0, 100, 21)[:, None]
    write_dpc(tmp_path / "in.dpc", MotionClip(10.0, "fapu", values))
    return tmp_path / "in.dpc"


def test_a_recording_at_another_rate(tmp_path: Path, recording: Path) -> None:
    shares: list[float] = []
    done = export_file(ExportRequest(tmp_path / "out.dpc", dpc=recording, fps="5"), shares.append)
    assert (done.frames, done.seconds, done.fps) == (11, pytest.approx(2.0), 5.0)
    assert len(read_dpc(tmp_path / "out.dpc").displacements) == 11
    assert shares[-1] == 1.0


def test_an_emotion_at_its_strongest_as_a_mesh_in_the_files_order(tmp_path: Path) -> None:
    export_file(ExportRequest(tmp_path / "out.obj", emotion="surprise"))
    moved, still = load_mesh(tmp_path / "out.obj"), load_mesh(DEFAULT_HEAD)
    np.testing.assert_array_equal(moved.triangles, still.triangles)
    assert 1.0 < np.abs(moved.vertices - still.vertices).max() < 6.0


def test_the_same_command_writes_the_same_file(tmp_path: Path) -> None:
    for name in ("a.dpc", "b.dpc"):
        export_file(ExportRequest(tmp_path / name, emotion="joy"))
    assert (tmp_path / "a.dpc").read_bytes() == (tmp_path / "b.dpc").read_bytes()


@pytest.mark.parametrize(
    ("wish", "text"),
    [
        ({"emotion": "glee"}, "there is no emotion 'glee': choose one of joy, surprise"),
        ({}, "nothing to export: give --dpc FILE or --emotion NAME"),
        ({"emotion": "joy", "size": "big"}, "size must be WIDTHxHEIGHT"),
        ({"emotion": "joy", "fps": "0"}, "fps must be 1 to 120"),
        ({"emotion": "joy", "at": 60.0}, r"the motion lasts 3\.\d\d seconds: there is nothing at 60"),
    ],
)
def test_what_is_wrong_is_said(tmp_path: Path, wish: dict[str, object], text: str) -> None:
    with pytest.raises(ConfError, match=text):
        export_file(ExportRequest(tmp_path / "a.obj", **wish))  # type: ignore[arg-type]


def test_a_face_without_points_says_how_to_get_them(tmp_path: Path) -> None:
    face = tmp_path / "face.obj"
    face.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", encoding="utf-8")
    with pytest.raises(ConfError, match=r"has no control points: run `conf fit .*face\.obj` or give --ppc FILE"):
        export_file(ExportRequest(tmp_path / "a.obj", emotion="joy", face=face))
