"""Generated clips of every kind that people have: times, sizes and pixels are known."""

import os
import struct
from fractions import Fraction
from pathlib import Path
from typing import Any

import av
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from conf.errors import CameraError
from conf.sender.capture.clip import _Decoder, open_clip, read_sound
from conf.sender.capture.frame import Frame
from tests.support.generated_clips import SIZE, SPEED, image, square_left, write_clip

TIMES = [i / 25 for i in range(25)]
UNEVEN = [0.0, 0.04, 0.08, 0.32, 0.36, 0.92, 1.00]


def read_all(path: Path | str) -> list[Frame]:
    with open_clip(path) as clip:
        frames = []
        while (frame := clip.read()) is not None:
            frames.append(frame)
        assert all(frame.pixels.shape[1::-1] == clip.size for frame in frames)
    return frames


def check_motion(frames: list[Frame], *, tolerance: float = 1.5) -> None:
    """Check that the square is where it was at each frame's own time."""
    for frame in frames:
        assert square_left(frame.pixels) == pytest.approx(SPEED * frame.timestamp, abs=tolerance)


@pytest.fixture(scope="module")
def plain(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_clip(tmp_path_factory.mktemp("clips") / "plain.mp4", TIMES)


def test_frames_have_pixels_and_times(plain: Path) -> None:
    frames = read_all(plain)
    assert [frame.timestamp for frame in frames] == pytest.approx(TIMES)
    assert frames[0].pixels.dtype == np.uint8 and frames[0].pixels.flags.c_contiguous
    assert np.abs(frames[5].pixels.astype(int) - image(TIMES[5])).mean() < 4
    check_motion(frames)
    with open_clip(plain) as clip:
        assert (clip.fps, clip.frame_count, clip.size) == (25.0, 25, SIZE)


@pytest.mark.parametrize(("max_pixels", "threads"), [(SIZE[0] * SIZE[1], "NONE"), (SIZE[0] * SIZE[1] - 1, "AUTO")])
def test_one_thread_decodes_a_small_clip_at_its_own_speed(
    max_pixels: int, threads: str, plain: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("conf.sender.capture.clip.MAX_SINGLE_THREAD_PIXELS", max_pixels)
    with open_clip(plain, is_paced=True, loop=True) as clip:
        paced = [clip.read() for _ in range(26)]
        assert clip._decoder._stream.thread_type.name == threads
    for frame, expected in zip(paced, read_all(plain), strict=False):
        assert frame is not None
        np.testing.assert_array_equal(frame.pixels, expected.pixels)


def test_only_images_that_are_asked_for_are_converted(plain: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    converted, expected = list[float](), read_all(plain)

    def convert(self: object, frame: Any, aspect: float) -> Any:
        converted.append(frame.time)
        return image(0.0)

    monkeypatch.setattr(_Decoder, "_to_bgr", convert)
    with open_clip(plain) as clip:
        frames = [clip.read() for _ in range(5)]
        assert len(converted) == 1  # the first: whether this kind can be converted
    monkeypatch.undo()
    with open_clip(plain) as clip:
        frames = [clip.read() for _ in range(5)]
    for frame, other in zip(frames, expected, strict=False):  # after the file was closed
        assert frame is not None
        np.testing.assert_array_equal(frame.pixels, other.pixels)


def test_variable_frame_rates_keep_each_frames_time(tmp_path: Path) -> None:
    frames = read_all(write_clip(tmp_path / "uneven.mkv", UNEVEN))
    assert [frame.timestamp for frame in frames] == pytest.approx(UNEVEN)
    check_motion(frames)


def test_interlaced_clips_are_deinterlaced(tmp_path: Path) -> None:
    options = {"flags": "+ilme+ildct", "top": "1"}
    path = write_clip(tmp_path / "fields.mpg", TIMES, codec="mpeg2video", interlaced=True, options=options)
    frames = read_all(path)
    assert len(frames) == len(TIMES)
    check_motion(frames, tolerance=2.0)
    edge = frames[10].pixels[SIZE[1] // 2 + 4 : SIZE[1] // 2 + 20].mean(axis=2)  # the square's rows: no comb
    lefts = np.array([np.flatnonzero(row > 176)[0] for row in edge])
    assert np.ptp(lefts) <= 1


@pytest.mark.slow
def test_pixels_are_made_square(tmp_path: Path) -> None:
    frames = read_all(write_clip(tmp_path / "wide.mp4", TIMES, aspect=Fraction(2, 1)))
    assert frames[0].pixels.shape == (SIZE[1], 2 * SIZE[0], 3)
    check_motion(frames, tolerance=3.0)
    frames = read_all(write_clip(tmp_path / "tall.mp4", TIMES, aspect=Fraction(1, 2)))
    assert frames[0].pixels.shape == (2 * SIZE[1], SIZE[0], 3)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("codec", "pix_fmt"),
    [
        ("libx264", "yuv420p10le"), ("ffv1", "gray"), ("ffv1", "yuv444p"), ("qtrle", "argb"),
        ("prores_ks", "yuva444p10le"),
        ("libvpx-vp9", "yuv420p"), ("libsvtav1", "yuv420p"), ("mjpeg", "yuvj420p"), ("msmpeg4", "yuv420p"),
    ],
)  # fmt: skip
def test_every_coding_and_pixel_format_becomes_bgr(
    tmp_path: Path, codec: str, pix_fmt: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SVT_LOG", "0")
    options = {"cpu-used": "8"} if codec == "libvpx-vp9" else {}
    suffix = "mov" if codec in ("prores_ks", "qtrle") else "mkv"
    frames = read_all(write_clip(tmp_path / f"clip.{suffix}", TIMES[:6], codec=codec, pix_fmt=pix_fmt, options=options))
    assert len(frames) == 6
    check_motion(frames)
    if pix_fmt != "gray":
        red = frames[0].pixels[:20].reshape(-1, 3).mean(axis=0)
        assert red[2] > 150 and red[0] < 60 and red[1] < 60


def test_a_rotated_clip_is_turned_upright(tmp_path: Path, plain: Path) -> None:
    content = bytearray(plain.read_bytes())
    matrix = content.index(b"tkhd") + 4 + 40  # ISO 14496-12: the display matrix, nine fixed-point numbers
    content[matrix : matrix + 36] = struct.pack(">9i", 0, 1 << 16, 0, -1 << 16, 0, 0, SIZE[1] << 16, 0, 1 << 30)
    (tmp_path / "rotated.mp4").write_bytes(bytes(content))
    frame = read_all(tmp_path / "rotated.mp4")[0]
    assert frame.pixels.shape == (SIZE[0], SIZE[1], 3)
    right = frame.pixels[:, -20:].reshape(-1, 3).mean(axis=0)  # the red band was above: clockwise it is on the right
    assert right[2] > 150 and right[0] < 60 and right[1] < 60


@pytest.mark.parametrize(
    "name", ["12:30.mp4", "2024-01-01T12:30:05.mp4", "été.mp4", "100%.mp4", "a b'c.mp4", b"na\xefve.mp4"]
)
def test_any_file_name_can_be_read(tmp_path: Path, plain: Path, name: str | bytes) -> None:
    path = os.path.join(os.fsencode(tmp_path), os.fsencode(name))
    with open(path, "wb") as copy:
        copy.write(plain.read_bytes())
    assert len(read_all(os.fsdecode(path))) == len(TIMES)


def test_a_row_of_pictures_is_a_clip(tmp_path: Path) -> None:
    for i in range(4):
        frame = av.VideoFrame.from_ndarray(image(i / 25), format="bgr24")
        with av.open(str(tmp_path / f"f{i:04d}.png"), "w", format="image2", options={"update": "1"}) as container:
            stream: Any = container.add_stream("png", rate=25)
            stream.width, stream.height, stream.pix_fmt = *SIZE, "rgb24"
            container.mux(stream.encode(frame))
            container.mux(stream.encode())
    frames = read_all(f"{tmp_path}/f%04d.png")
    assert [frame.timestamp for frame in frames] == pytest.approx([i / 25 for i in range(4)])
    check_motion(frames)


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("nosuch.avi", r"there is no file .*nosuch\.avi: check the path"),
        ("nosuch%.avi", r"there is no file .*nosuch%\.avi: check the path"),
        ("none%04d.png", r"there is no file .*none%04d\.png: check the path"),
        ("http://example.org/a.mp4", r"is an address, not a file: download the clip first"),
        ("rtsp://10.0.0.1/a", r"is an address, not a file"),
        (str(Path("https://example.org/a.mp4")), r"is an address, not a file"),
        ("C:/Users/me/a.mp4", r"there is no file C:/Users/me/a\.mp4: check the path"),
    ],
)
def test_what_is_not_there_is_named(name: str, text: str) -> None:
    with pytest.raises(CameraError, match=text):
        open_clip(name)


def test_a_folder_and_a_text_are_no_clips(tmp_path: Path) -> None:
    with pytest.raises(CameraError, match=r"cannot be opened \(Is a directory\): give a video file"):
        open_clip(tmp_path)
    (tmp_path / "notes.mp4").write_text("not a video at all, whatever its name says\n" * 50)
    with pytest.raises(CameraError, match=r"is not a video that can be read \(.*\): give one such as MP4"):
        open_clip(tmp_path / "notes.mp4")
    (tmp_path / "empty.mp4").write_bytes(b"")
    with pytest.raises(CameraError, match="is not a video that can be read"):
        open_clip(tmp_path / "empty.mp4")


def test_a_file_of_sound_has_no_picture(tmp_path: Path) -> None:
    with av.open(str(tmp_path / "tone.wav"), "w") as container:
        stream: Any = container.add_stream("pcm_s16le", rate=8000)
        block = av.AudioFrame.from_ndarray(np.zeros((1, 800), np.int16), format="s16", layout="mono")
        block.sample_rate = 8000
        container.mux(stream.encode(block))
        container.mux(stream.encode())
    with pytest.raises(CameraError, match=r"tone\.wav has no picture: give a video"):
        open_clip(tmp_path / "tone.wav")


def test_a_loop_goes_on_in_time(plain: Path) -> None:
    with open_clip(plain, loop=True) as clip:
        frames = [clip.read() for _ in range(60)]
    times = [frame.timestamp for frame in frames if frame is not None]
    assert np.diff(times) == pytest.approx([0.04] * 59)
    first, again = frames[0], frames[25]
    assert first is not None and again is not None and np.array_equal(first.pixels, again.pixels)


def test_times_that_make_no_sense_are_replaced(tmp_path: Path) -> None:
    times = [0.0, 0.04, 90.0, 90.04, 90.08]  # a jump of a minute and a half
    frames = read_all(write_clip(tmp_path / "jump.mkv", times))
    assert [frame.timestamp for frame in frames] == pytest.approx([0.0, 0.04, 0.08, 0.12, 0.16])


@pytest.mark.slow
def test_the_sound_track_is_read_beside_the_picture(tmp_path: Path) -> None:
    path = write_clip(tmp_path / "tone.mp4", TIMES, sound_seconds=1.0)
    blocks = list(read_sound(path, rate=16000))
    samples = np.concatenate([block for _, block in blocks])
    assert samples.dtype == np.int16 and len(samples) / 16000 == pytest.approx(1.0, abs=0.1)
    spectrum = np.abs(np.fft.rfft(samples[4000:12000]))
    assert spectrum.argmax() * 16000 / 8000 == pytest.approx(440, abs=2)
    starts = np.array([at for at, _ in blocks])
    assert (np.diff(starts) > 0).all() and abs(starts[0]) < 0.05
    assert list(read_sound(write_clip(tmp_path / "silent.mp4", TIMES[:3]))) == []


@pytest.mark.slow
@settings(max_examples=40)
@given(data=st.data())
def test_damaged_clips_give_frames_or_one_error(plain: Path, data: st.DataObject) -> None:
    content = bytearray(plain.read_bytes())
    for _ in range(data.draw(st.integers(1, 30))):
        content[data.draw(st.integers(0, len(content) - 1))] = data.draw(st.integers(0, 255))
    del content[data.draw(st.integers(0, len(content))) :]
    path = plain.with_name("damaged.mp4")
    path.write_bytes(bytes(content))
    try:
        frames = read_all(path)
    except CameraError:
        return
    assert all(frame.timestamp >= 0 for frame in frames)
