"""Clips are read back by OpenCV, by PyAV and by our own reader; the files of killed programs can be played."""

import os
import subprocess
import sys
from pathlib import Path

import av
import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from conf.errors import RecordingError
from conf.output import clip_encoder
from conf.output.clip_encoder import CLIP_FORMATS, ClipEncoder, clip_format, move_index_to_front
from conf.sender.capture.clip import open_clip

FPS = 15.0
NAMES = ("a.mp4", "a.avi")


def ramp(width: int = 64, height: int = 48) -> NDArray[np.uint8]:
    pixels = np.zeros((height, width, 3), np.uint8)
    pixels[..., 0] = np.linspace(0, 255, width)
    pixels[..., 2] = np.linspace(0, 255, height)[:, None]
    return pixels


def encode(path: Path, times: list[float], size: tuple[int, int] = (64, 48)) -> Path:
    encoder = ClipEncoder(path, clip_format(path), size, fps=FPS)
    for time in times:
        encoder.encode_frame(ramp(*size), time)
    encoder.close()
    return path


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_opencv_and_our_reader_see_the_frames_their_times_and_colours(tmp_path: Path, name: str) -> None:
    path = encode(tmp_path / name, [i / FPS for i in range(7)])
    capture = cv2.VideoCapture(str(path))
    assert capture.get(cv2.CAP_PROP_FPS) == pytest.approx(FPS)
    assert capture.get(cv2.CAP_PROP_FRAME_COUNT) == 7
    with open_clip(path) as clip:
        assert (clip.fps, clip.frame_count, clip.size) == (pytest.approx(FPS), 7, (64, 48))
        for i in range(7):
            is_read, pixels = capture.read()
            frame = clip.read()
            assert is_read and frame and frame.timestamp == pytest.approx(i / FPS, abs=1e-4)
            np.testing.assert_allclose(pixels.astype(int), ramp().astype(int), atol=24)
            np.testing.assert_allclose(frame.pixels.astype(int), ramp().astype(int), atol=24)
            assert np.abs(frame.pixels.astype(int) - ramp()).mean() < 3  # range and matrix are those that are stated
        assert clip.read() is None


def test_uneven_times_are_kept(tmp_path: Path) -> None:
    times = [0.0, 0.05, 0.31, 0.4, 2.0]
    with open_clip(encode(tmp_path / "a.mp4", times)) as clip:
        read = [frame.timestamp for frame in iter(clip.read, None)]
    assert read == pytest.approx(times, abs=1e-4)


@pytest.mark.parametrize(("name", "size"), [("a.mp4", (66, 50)), ("a.avi", (65, 49))])
def test_an_odd_size_is_extended_by_its_last_row_and_column_if_the_format_needs_it(
    tmp_path: Path, name: str, size: tuple[int, int]
) -> None:
    with open_clip(encode(tmp_path / name, [0.0], (65, 49))) as clip:
        frame = clip.read()
        assert clip.size == size and frame is not None
        np.testing.assert_allclose(frame.pixels[:49, :65].astype(int), ramp(65, 49).astype(int), atol=40)
        np.testing.assert_allclose(frame.pixels[:, -1].astype(int)[:49], ramp(65, 49)[:, -1].astype(int), atol=40)


def test_without_h264_mp4_has_mpeg4(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("conf.output.clip_encoder.av.codecs_available", {"mpeg4"})
    path = encode(tmp_path / "a.mp4", [0.0, 0.1])
    with av.open(path) as container:
        assert container.streams.video[0].codec.name == "mpeg4"
    with open_clip(path) as clip:
        assert len(list(iter(clip.read, None))) == 2


def test_the_index_moves_to_the_front(tmp_path: Path) -> None:
    path = encode(tmp_path / "a.mp4", [i / FPS for i in range(5)])
    copy = tmp_path / "b.mp4"
    assert move_index_to_front(path, CLIP_FORMATS[".mp4"], copy)
    before, after = path.read_bytes(), copy.read_bytes()
    assert before.find(b"moov") > before.find(b"mdat") and 0 < after.find(b"moov") < after.find(b"mdat")
    with open_clip(copy) as clip:
        assert [f.timestamp for f in iter(clip.read, None)] == pytest.approx([i / FPS for i in range(5)], abs=1e-4)
    assert not move_index_to_front(path, CLIP_FORMATS[".avi"], tmp_path / "c.avi")


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_the_clip_of_a_killed_program_can_be_played(tmp_path: Path, name: str) -> None:
    code = (
        "import os, sys; from pathlib import Path; from tests.output.test_clip_encoder import *\n"
        "path = Path(sys.argv[1]); encoder = ClipEncoder(path, clip_format(path), (64, 48), fps=FPS)\n"
        "for i in range(150): encoder.encode_frame(ramp(), i / FPS)\n"
        "os._exit(9)"
    )
    root = str(Path(__file__).parents[2])
    done = subprocess.run(
        [sys.executable, "-c", code, str(tmp_path / name)], env=os.environ | {"PYTHONPATH": root}, check=False
    )
    assert done.returncode == 9
    with open_clip(tmp_path / name) as clip:
        seconds = len(list(iter(clip.read, None))) / FPS
    assert seconds >= 10 - 2 * clip_encoder.KEYFRAME_INTERVAL_S


@pytest.mark.parametrize("name", ["a.mov", "a", "mp4"])
def test_an_unknown_suffix_is_refused_with_those_that_work(name: str) -> None:
    with pytest.raises(RecordingError, match=f"{name}: the name of a clip must end in .mp4 or .avi"):
        clip_format(Path(name))


def test_sound_needs_a_rate(tmp_path: Path) -> None:
    encoder = ClipEncoder(tmp_path / "a.mp4", CLIP_FORMATS[".mp4"], (64, 48), fps=FPS)
    with pytest.raises(ValueError, match="audio_rate must be given"):
        encoder.encode_audio(np.zeros(10, np.int16), 0)
    encoder.close()
