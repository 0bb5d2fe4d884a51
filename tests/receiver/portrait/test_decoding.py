import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.errors import ProtocolError
from conf.receiver.portrait.decoding import decode_image
from tests.support.drawn_person import draw_person, encode_vp8


def test_a_decoded_image_resembles_the_encoded_one() -> None:
    pixels = draw_person()
    assert np.abs(decode_image(encode_vp8(pixels)).astype(float) - pixels).mean() < 3


@given(st.integers(0, 2**32 - 1))
def test_a_damaged_image_is_decoded_or_a_protocol_error(seed: int) -> None:
    rng = np.random.default_rng(seed)
    frame = bytearray(encode_vp8(draw_person()[:64, :64]))
    for index in rng.integers(10, len(frame), 8):
        frame[index] = rng.integers(256)
    try:
        assert decode_image(bytes(frame[: rng.integers(5, len(frame) + 1)])).shape == (64, 64, 3)
    except ProtocolError:
        pass


def test_a_header_without_data_is_a_protocol_error() -> None:
    with pytest.raises(ProtocolError):
        decode_image(encode_vp8(draw_person())[:10])
