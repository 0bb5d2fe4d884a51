from pathlib import Path

import numpy as np
import pytest

from conf.commands.export import ExportRequest, export_file
from conf.errors import ConfError
from conf.face.default_head import DEFAULT_HEAD
from conf.face.formats.dpc import MotionClip, read_dpc, write_dpc
from conf.face.mesh.mesh import load_mesh
from conf.output.wav_writer import write_wav
from conf.sender.capture.clip import read_sound


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


@pytest.mark.slow
def test_sound_needs_a_clip_and_a_sound_track(tmp_path: Path) -> None:
    write_wav(tmp_path / "s.wav", np.zeros(4800, np.int16))
    request = ExportRequest(tmp_path / "joy.png", emotion="joy", sound=tmp_path / "s.wav")
    with pytest.raises(ConfError, match=r"joy\.png holds no sound: give a clip \(\.mp4 \.avi\)"):
        export_file(request)


@pytest.mark.slow
def test_a_clip_is_written_with_sound(tmp_path: Path) -> None:
    write_wav(tmp_path / "s.wav", (8000 * np.sin(2 * np.pi * 440 * np.arange(24000) / 48000)).astype(np.int16))
    output = tmp_path / "joy.mp4"
    result = export_file(ExportRequest(output, emotion="joy", size="64x64", fps="10", sound=tmp_path / "s.wav"))
    samples = np.concatenate([block for _, block in read_sound(output, rate=16000)])
    assert np.abs(samples[1000:7000]).max() > 6000 and np.abs(samples[9500:]).max(initial=0) < 500
    assert result.seconds > 0.5
