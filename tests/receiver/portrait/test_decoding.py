import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.errors import ProtocolError
from conf.receiver.portrait.decoding import decode_picture
from tests.support.drawn_person import draw_person, vp8


def test_a_picture_comes_back() -> None:
    pixels = draw_person()
    assert np.abs(decode_picture(vp8(pixels)).astype(float) - pixels).mean() < 3


@given(st.integers(0, 2**32 - 1))
def test_damaged_pictures_are_pictures_or_the_one_error(seed: int) -> None:
    rng = np.random.default_rng(seed)
    frame = bytearray(vp8(draw_person()[:64, :64]))
    for at in rng.integers(10, len(frame), 8):
        frame[at] = rng.integers(256)
    try:
        assert decode_picture(bytes(frame[: rng.integers(5, len(frame) + 1)])).shape == (64, 64, 3)
    except ProtocolError:
        pass


def test_a_header_alone_is_refused() -> None:
    with pytest.raises(ProtocolError):
        decode_picture(vp8(draw_person())[:10])
