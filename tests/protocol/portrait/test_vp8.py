"""The VP8 frame of a WebP file, and its size."""

import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.errors import ProtocolError
from conf.protocol.portrait.vp8 import read_frame_size, strip_riff, wrap_riff
from tests.support.portrait_objects import webp

FRAME = strip_riff(webp(160, 120))


def resized(width: int, height: int) -> bytes:
    """Return the frame with another size in its header."""
    return FRAME[:6] + struct.pack("<HH", width, height) + FRAME[10:]


@pytest.mark.parametrize("size", [(160, 120), (33, 17), (8, 8), (100, 31)])
def test_the_riff_header_is_removed_and_restored(size: tuple[int, int]) -> None:
    whole = webp(*size)
    frame = strip_riff(whole)
    assert whole[20:].rstrip(b"\0") == frame.rstrip(b"\0")
    assert wrap_riff(frame) == whole
    assert read_frame_size(frame) == size


def test_odd_frames_are_padded_in_the_file() -> None:
    assert wrap_riff(b"abc") == b"RIFF" + struct.pack("<I", 16) + b"WEBPVP8 " + struct.pack("<I", 3) + b"abc\0"
    assert wrap_riff(b"ab") == b"RIFF" + struct.pack("<I", 14) + b"WEBPVP8 " + struct.pack("<I", 2) + b"ab"
    assert strip_riff(wrap_riff(b"abc")) == b"abc"
    assert strip_riff(wrap_riff(b"")) == b""


@given(st.binary(max_size=40))
def test_any_bytes_have_a_small_size_or_are_rejected(data: bytes) -> None:
    try:
        width, height = read_frame_size(data)
        assert 0 < width * height <= 640 * 640
    except ProtocolError:
        pass


@pytest.mark.parametrize("size", [(1024, 400), (400, 1024), (640, 640), (1, 1)])
def test_images_up_to_the_limits_are_accepted(size: tuple[int, int]) -> None:
    assert read_frame_size(resized(*size)) == size
    assert read_frame_size(resized(size[0] | 0x4000, size[1] | 0x8000)) == size, "the upper two bits are the scaling"


@pytest.mark.parametrize("size", [(1025, 300), (300, 1025), (640, 641), (0, 9), (9, 0), (16383, 16383)])
def test_larger_images_are_rejected_before_decoding(size: tuple[int, int]) -> None:
    with pytest.raises(ProtocolError, match=f"an image of {size[0]} x {size[1]} is too large"):
        read_frame_size(resized(*size))


def test_a_frame_that_ends_inside_its_first_partition_is_rejected() -> None:
    size = (FRAME[0] | FRAME[1] << 8 | FRAME[2] << 16) >> 5
    assert read_frame_size(FRAME[: 10 + size]) == (160, 120)
    with pytest.raises(ProtocolError, match="cut off"):
        read_frame_size(FRAME[: 9 + size])
    with pytest.raises(ProtocolError, match="cut off"):
        read_frame_size(FRAME[:2] + b"\x01" + FRAME[3:])


@pytest.mark.parametrize("frame", [b"", FRAME[:9], bytes((FRAME[0] | 1,)) + FRAME[1:], FRAME[:3] + b"\0" + FRAME[4:]])
def test_other_data_is_no_key_frame(frame: bytes) -> None:
    with pytest.raises(ProtocolError, match="not a VP8 key frame"):
        read_frame_size(frame)


def test_the_shortest_key_frame_has_ten_bytes() -> None:
    assert read_frame_size(b"\0\0\0\x9d\x01\x2a\x08\0\x09\0") == (8, 9)


@pytest.mark.parametrize(
    ("data", "error"),
    [
        (b"RIFF" + bytes(15), "must be a WebP file"),
        (b"RIFF" + bytes(30), "must be a simple lossy WebP file"),
        (b"RIFF\0\0\0\0WEBPVP8L\0\0\0\0", "must be a simple lossy WebP file"),
    ],
)
def test_other_files_are_rejected(data: bytes, error: str) -> None:
    with pytest.raises(ValueError, match=error):
        strip_riff(data)
