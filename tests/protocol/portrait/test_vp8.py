import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.errors import ProtocolError
from conf.protocol.portrait.vp8 import read_frame_size, strip_riff, wrap_riff
from tests.support.portrait_objects import webp


def test_twenty_bytes_are_left_out_and_put_back() -> None:
    whole = webp(160, 120)
    frame = strip_riff(whole)
    assert len(frame) <= len(whole) - 20
    assert wrap_riff(frame) == whole
    assert read_frame_size(frame) == (160, 120)


@given(st.binary(max_size=40))
def test_any_bytes_have_a_small_size_or_are_refused(data: bytes) -> None:
    try:
        width, height = read_frame_size(data)
        assert 0 < width * height <= 640 * 640
    except ProtocolError:
        pass


def test_giant_dimensions_are_refused_before_decoding() -> None:
    frame = bytearray(strip_riff(webp(64, 64)))
    frame[6:10] = (16383).to_bytes(2, "little") * 2
    with pytest.raises(ProtocolError, match="16383 x 16383 is too large"):
        read_frame_size(bytes(frame))


def test_cut_off_pictures_and_other_kinds_are_refused() -> None:
    with pytest.raises(ProtocolError, match="cut off"):
        read_frame_size(strip_riff(webp(64, 64))[:12])
    with pytest.raises(ValueError, match="simple lossy WebP"):
        strip_riff(b"RIFF" + bytes(30))
