"""Odd clips that people have, each generated here with the value that must be read."""

import os
import socket
import struct
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from typing import Any

import av
import numpy as np
import pytest
from PIL import Image

from conf.errors import CameraError
from conf.sender.capture.clip import MAX_PIXELS, open_clip, read_sound
from conf.sender.capture.frame import Frame
from tests.support.generated_clips import SIZE, SPEED, image, square_left, write_clip

TIMES = [i / 25 for i in range(25)]


def read_all(path: Path | str) -> list[Frame]:
    with open_clip(path) as clip:
        return list(iter(clip.read, None))


def check_motion(frames: list[Frame], *, tolerance: float = 1.5) -> None:
    for frame in frames:
        assert square_left(frame.pixels) == pytest.approx(SPEED * frame.timestamp, abs=tolerance)


def write_frames(path: Path, images: list[np.ndarray], *, codec: str, stamps: list[int] | None = None) -> Path:
    """Write images; stamps : their times in frames of a 25th of a second, written into the packets as they are."""
    with av.open(str(path), "w") as container:
        stream: Any = container.add_stream(codec, rate=25)
        stream.height, stream.width = images[0].shape[:2]
        stream.pix_fmt = "yuv420p"
        packets = []
        for i, pixels in enumerate(images):
            frame = av.VideoFrame.from_ndarray(pixels, format="bgr24").reformat(format="yuv420p")
            frame.pts, frame.time_base = i, Fraction(1, 25)
            packets += stream.encode(frame)
        for i, packet in enumerate([*packets, *stream.encode()]):
            if stamps is not None:
                packet.pts, packet.time_base = stamps[i], Fraction(1, 25)
                packet.dts = i  # a muxer refuses decoding times that do not rise
            container.mux(packet)
    return path


# Timestamps


@pytest.mark.slow
@pytest.mark.parametrize("frames_between", ["0", "3"])
def test_avi_with_b_frames_plays_in_order_and_at_its_rate(tmp_path: Path, frames_between: str) -> None:
    path = write_clip(tmp_path / "b.avi", TIMES, codec="libx264", options={"bf": frames_between, "crf": "10"})
    frames = read_all(path)
    assert [frame.timestamp for frame in frames] == pytest.approx(TIMES)
    check_motion(frames)


@pytest.mark.parametrize("start", [-3.0, 95443.0])
def test_a_clip_may_start_at_any_time(tmp_path: Path, start: float) -> None:
    path = write_clip(tmp_path / "start.mkv", [start + at for at in TIMES[:5]])
    assert [frame.timestamp for frame in read_all(path)] == pytest.approx(TIMES[:5], abs=0.001)


def test_joined_transport_streams_go_on_in_time(tmp_path: Path) -> None:
    part = write_clip(tmp_path / "part.ts", TIMES[:10], codec="mpeg2video")
    (tmp_path / "joined.ts").write_bytes(part.read_bytes() * 2)
    frames = read_all(tmp_path / "joined.ts")
    assert len(frames) >= 19
    assert np.diff([frame.timestamp for frame in frames]) == pytest.approx([0.04] * (len(frames) - 1))


def test_a_hole_in_the_middle_keeps_the_time_after_it(tmp_path: Path) -> None:
    path = write_clip(tmp_path / "whole.ts", TIMES, codec="mpeg2video", options={"g": "5"})
    data = path.read_bytes()
    packets = [data[i : i + 188] for i in range(0, len(data), 188)]
    third = len(packets) // 3
    (tmp_path / "hole.ts").write_bytes(b"".join(packets[:third] + packets[2 * third :]))
    frames = read_all(tmp_path / "hole.ts")
    assert 8 < len(frames) < 24 and frames[-1].timestamp == pytest.approx(TIMES[-1])
    check_motion(frames[-5:])


def test_a_clip_that_begins_in_the_middle_starts_with_its_first_whole_frame(tmp_path: Path) -> None:
    options = {"g": "12", "x264-params": "open-gop=0"}
    data = write_clip(tmp_path / "whole.ts", TIMES, codec="libx264", options=options).read_bytes()
    start = len(data) // 188 // 4 * 188
    (tmp_path / "late.ts").write_bytes(data[:376] + data[start:])  # with the tables that name the streams
    frames = read_all(tmp_path / "late.ts")
    assert 5 < len(frames) < 25 and frames[0].timestamp == 0.0
    lefts = np.array([square_left(frame.pixels) for frame in frames])
    assert np.diff(lefts) == pytest.approx([SPEED / 25] * (len(frames) - 1), abs=1.5)


# Orientation, size, interlacing


def with_matrix(path: Path, a: int, b: int, c: int, d: int) -> Path:
    """Set the display matrix of an MP4 file. Source: ISO/IEC 14496-12, 8.3.2."""
    content = bytearray(path.read_bytes())
    start = content.index(b"tkhd") + 4 + 40
    content[start : start + 36] = struct.pack(">9i", a << 16, b << 16, 0, c << 16, d << 16, 0, 0, 0, 1 << 30)
    path.write_bytes(bytes(content))
    return path


@pytest.mark.parametrize(
    ("values", "restore"),
    [
        ((-1, 0, 0, 1), lambda pixels: pixels[:, ::-1]),
        ((1, 0, 0, -1), lambda pixels: pixels[::-1]),
        ((-1, 0, 0, -1), lambda pixels: pixels[::-1, ::-1]),
        ((0, 1, 1, 0), lambda pixels: pixels.transpose(1, 0, 2)),
    ],
    ids=["mirrored", "flipped", "turned", "transposed"],
)
@pytest.mark.parametrize("interlaced", [False, True])
def test_a_clip_is_mirrored_as_it_says(
    tmp_path: Path, values: tuple[int, int, int, int], restore: Callable[[np.ndarray], np.ndarray], interlaced: bool
) -> None:
    options = {"flags": "+ilme+ildct", "top": "1"} if interlaced else {}
    codec = "mpeg2video" if interlaced else "mpeg4"
    path = write_clip(tmp_path / "clip.mp4", TIMES[:5], codec=codec, interlaced=interlaced, options=options)
    plain = read_all(path)[2].pixels
    assert np.array_equal(restore(read_all(with_matrix(path, *values))[2].pixels), plain)


def test_a_photo_is_turned_as_its_exif_data_say(tmp_path: Path) -> None:
    photo = Image.fromarray(np.ascontiguousarray(image(0.0)[..., ::-1]))
    exif = Image.Exif()
    exif[0x0112] = 6  # to be turned clockwise
    photo.save(tmp_path / "photo.jpg", exif=exif, quality=95)
    (frame,) = read_all(tmp_path / "photo.jpg")
    assert frame.pixels.shape == (SIZE[0], SIZE[1], 3)
    right = frame.pixels[:, -20:].reshape(-1, 3).mean(axis=0)
    assert right[2] > 150 and right[0] < 60


@pytest.mark.parametrize("interlaced", [False, True])
def test_a_clip_that_changes_its_size_keeps_the_first(tmp_path: Path, interlaced: bool) -> None:
    tall = np.full((160, 120, 3), 255, np.uint8)
    part = write_clip(
        tmp_path / "part.ts", TIMES[:10], codec="mpeg2video", interlaced=interlaced,
        options={"flags": "+ilme+ildct", "top": "1"} if interlaced else {},
    )  # fmt: skip
    other = write_frames(tmp_path / "tall.ts", [tall] * 10, codec="mpeg2video")
    (tmp_path / "joined.ts").write_bytes(part.read_bytes() + other.read_bytes())
    frames = read_all(tmp_path / "joined.ts")
    assert len(frames) >= 19 and {frame.pixels.shape for frame in frames} == {(SIZE[1], SIZE[0], 3)}
    check_motion(frames[:9], tolerance=2.0)
    assert frames[-1].pixels[:, 40:120].min() > 240 and frames[-1].pixels[:, :30].max() < 16  # black bars at the sides


@pytest.mark.parametrize("size", [(2, 2), (16, 2), (1, 1)])
def test_tiny_interlaced_clips_are_read(tmp_path: Path, size: tuple[int, int]) -> None:
    options = {"flags": "+ilme+ildct"}
    with av.open(str(tmp_path / "tiny.mkv"), "w") as container:
        stream: Any = container.add_stream("ffv1", rate=25, options=options)
        stream.width, stream.height, stream.pix_fmt = *size, "yuv444p"
        stream.codec_context.flags |= 1 << 29 | 1 << 18
        for i in range(3):
            frame = av.VideoFrame.from_ndarray(np.full((size[1], size[0], 3), 90, np.uint8), format="bgr24")
            frame = frame.reformat(format="yuv444p")
            frame.pts, frame.time_base = i, Fraction(1, 25)
            container.mux(stream.encode(frame))
        container.mux(stream.encode())
    assert [frame.pixels.shape for frame in read_all(tmp_path / "tiny.mkv")] == [(size[1], size[0], 3)] * 3


def test_pictures_that_are_too_large_are_refused_before_they_are_decoded(tmp_path: Path) -> None:
    data = write_clip(tmp_path / "clip.avi", TIMES[:2], codec="rawvideo").read_bytes()
    side = int(MAX_PIXELS**0.5) + 16
    header = data.index(b"strf") + 12
    (tmp_path / "huge.avi").write_bytes(data[:header] + struct.pack("<ii", side, side) + data[header + 8 :])
    with pytest.raises(CameraError, match=rf"has pictures of {side} x {side} pixels, more than can be read: make them"):
        open_clip(tmp_path / "huge.avi")


# Streams


def two_streams(path: Path, *, default: int, sizes: tuple[int, int]) -> Path:
    """Write two streams of squares of these sizes, the first green, the second red; one is marked as the default."""
    with av.open(str(path), "w") as container:
        streams: list[Any] = [container.add_stream("mpeg4", rate=25) for _ in sizes]
        for number, (stream, size) in enumerate(zip(streams, sizes, strict=True)):
            stream.width = stream.height = size
            stream.pix_fmt = "yuv420p"
            stream.disposition = av.stream.Disposition.default if number == default else av.stream.Disposition(0)
        for stream, size, colour in zip(streams, sizes, ((0, 200, 0), (0, 0, 200)), strict=True):
            frame = av.VideoFrame.from_ndarray(np.full((size, size, 3), colour, np.uint8), format="bgr24")
            container.mux(stream.encode(frame.reformat(format="yuv420p")))
            container.mux(stream.encode())
    return path


@pytest.mark.parametrize(
    ("default", "sizes", "expected"), [(0, (32, 64), 32), (1, (64, 32), 32), (-1, (32, 64), 64), (-1, (64, 32), 64)]
)
def test_of_two_streams_the_default_or_the_largest_is_shown(
    tmp_path: Path, default: int, sizes: tuple[int, int], expected: int
) -> None:
    (frame,) = read_all(two_streams(tmp_path / "two.mkv", default=default, sizes=sizes))
    assert frame.pixels.shape == (expected, expected, 3)


@pytest.mark.parametrize("suffix", ["mp3", "m4a", "flac"])
def test_a_cover_is_no_video(tmp_path: Path, suffix: str) -> None:
    with av.open(str(tmp_path / f"song.{suffix}"), "w", format="mp4" if suffix == "m4a" else suffix) as container:
        sound: Any = container.add_stream({"m4a": "aac"}.get(suffix, suffix), rate=44100)
        cover: Any = container.add_stream("png")
        cover.width, cover.height, cover.pix_fmt = 16, 16, "rgb24"
        cover.disposition = av.stream.Disposition.attached_pic
        container.mux(cover.encode(av.VideoFrame.from_ndarray(np.zeros((16, 16, 3), np.uint8), format="rgb24")))
        container.mux(cover.encode())
        samples = np.zeros((1, 1152), np.int16)
        for i in range(4):
            block = av.AudioFrame.from_ndarray(samples, format="s16", layout="mono")
            block.sample_rate, block.pts, block.time_base = 44100, 1152 * i, Fraction(1, 44100)
            for resampled in av.AudioResampler(format=sound.codec_context.format.name, rate=44100).resample(block):
                container.mux(sound.encode(resampled))
        container.mux(sound.encode())
    with pytest.raises(CameraError, match=rf"song\.{suffix} has no picture: give a video"):
        open_clip(tmp_path / f"song.{suffix}")


def test_an_unknown_coding_is_named_with_a_way_out(tmp_path: Path) -> None:
    data = write_clip(tmp_path / "clip.avi", TIMES[:2]).read_bytes()
    (tmp_path / "unknown.avi").write_bytes(data.replace(b"FMP4", b"Qxz7"))
    with pytest.raises(
        CameraError, match=r"has a picture in a coding that this program has no decoder for: convert it"
    ):
        open_clip(tmp_path / "unknown.avi")


def test_sound_that_changes_in_the_middle_goes_on(tmp_path: Path) -> None:
    for name, rate, layout in (("a", 48000, "stereo"), ("b", 32000, "mono")):
        with av.open(str(tmp_path / f"{name}.ts"), "w") as container:
            stream: Any = container.add_stream("mp2", rate=rate, layout=layout)
            for i in range(20):
                shape = (1, 1152 * (2 if layout == "stereo" else 1))
                block = av.AudioFrame.from_ndarray(np.full(shape, 1000, np.int16), format="s16", layout=layout)
                block.sample_rate, block.pts, block.time_base = rate, 1152 * i, Fraction(1, rate)
                container.mux(stream.encode(block))
            container.mux(stream.encode())
    joined = tmp_path / "joined.ts"
    joined.write_bytes((tmp_path / "a.ts").read_bytes() + (tmp_path / "b.ts").read_bytes())
    samples = np.concatenate([block for _, block in read_sound(joined, rate=16000)])
    assert len(samples) / 16000 == pytest.approx(20 * 1152 * (1 / 48000 + 1 / 32000), abs=0.1)


# Paths


def test_a_pipe_and_a_device_are_refused_at_once(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(CameraError, match=r"pipe is a pipe, not a file: write the clip to a file first"):
        open_clip(tmp_path / "pipe")
    with socket.socket(socket.AF_UNIX) as server:
        server.bind(str(tmp_path / "s"))
        with pytest.raises(CameraError, match="is a pipe, not a file"):
            open_clip(tmp_path / "s")
    with pytest.raises(
        CameraError, match=r"/dev/zero is a device, not a file: if it is a camera, give it with --camera"
    ):
        open_clip("/dev/zero")


@pytest.mark.parametrize("name", ["", "a" * 300, "a\0b"])
def test_impossible_names_are_errors(name: str) -> None:
    with pytest.raises(CameraError, match=r"cannot be opened|there is no file"):
        open_clip(name)
