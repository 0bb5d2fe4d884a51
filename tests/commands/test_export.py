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


@pytest.mark.slow
def test_a_recording_is_resampled(tmp_path: Path, recording: Path) -> None:
    fractions: list[float] = []
    result = export_file(ExportRequest(tmp_path / "out.dpc", dpc=recording, fps="5"), fractions.append)
    assert (result.frames, result.seconds, result.fps) == (11, pytest.approx(2.0), 5.0)
    assert len(read_dpc(tmp_path / "out.dpc").displacements) == 11
    assert fractions[-1] == 1.0


@pytest.mark.slow
def test_a_mesh_shows_the_peak_of_an_emotion(tmp_path: Path) -> None:
    export_file(ExportRequest(tmp_path / "out.obj", emotion="surprise"))
    moved, still = load_mesh(tmp_path / "out.obj"), load_mesh(DEFAULT_HEAD)
    np.testing.assert_array_equal(moved.triangles, still.triangles)
    assert 1.0 < np.abs(moved.vertices - still.vertices).max() < 6.0


@pytest.mark.slow
def test_the_same_command_writes_the_same_file(tmp_path: Path) -> None:
    for name in ("a.dpc", "b.dpc"):
        export_file(ExportRequest(tmp_path / name, emotion="joy"))
    assert (tmp_path / "a.dpc").read_bytes() == (tmp_path / "b.dpc").read_bytes()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("request_fields", "message"),
    [
        ({"emotion": "glee"}, "there is no emotion 'glee': choose one of joy, surprise"),
        ({}, "nothing to export: give --dpc FILE or --emotion NAME"),
        ({"emotion": "joy", "size": "big"}, "size must be WIDTHxHEIGHT"),
        ({"emotion": "joy", "fps": "0"}, "fps must be 1 to 120"),
        ({"emotion": "joy", "at": 60.0}, r"the motion lasts 3\.\d\d seconds: choose a time --at up to that"),
    ],
)
def test_an_invalid_request_is_an_error(tmp_path: Path, request_fields: dict[str, object], message: str) -> None:
    with pytest.raises(ConfError, match=message):
        export_file(ExportRequest(tmp_path / "a.obj", **request_fields))  # type: ignore[arg-type]


def test_a_face_without_points_is_an_error_that_names_conf_fit(tmp_path: Path) -> None:
    face = tmp_path / "face.obj"
    face.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", encoding="utf-8")
    with pytest.raises(ConfError, match=r"has no control points: run `conf fit .*face\.obj` or give --ppc FILE"):
        export_file(ExportRequest(tmp_path / "a.obj", emotion="joy", face=face))


@pytest.mark.slow
def test_what_was_wrong_with_the_mesh_is_said_in_one_line(tmp_path: Path) -> None:
    face = tmp_path / "face.obj"
    face.write_text("mtllib gone.mtl\n" + DEFAULT_HEAD.read_text().replace("mtllib head.mtl", "hello\nf 1 2"))
    face.with_suffix(".ppc").write_bytes(DEFAULT_HEAD.with_suffix(".ppc").read_bytes())
    notes: list[str] = []
    export_file(ExportRequest(tmp_path / "out.dpc", emotion="joy", face=face), on_note=notes.append)
    lines = "1 lines with an unknown keyword (first in line 3), 1 faces with fewer than three corners (first in line 4)"
    missing = "the material library gone.mtl was not found beside the mesh"
    assert notes == [f"{face}: skipped {lines}; {missing}"]
