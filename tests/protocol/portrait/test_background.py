import msgpack
import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.errors import ProtocolError
from conf.protocol.portrait.background import decode_background, encode_background
from tests.support.portrait_objects import example_background


def test_a_background_is_what_was_encoded() -> None:
    background = example_background()
    decoded = decode_background(encode_background(background))
    assert (decoded.photo_number, decoded.frame) == (background.photo_number, background.frame)
    assert decoded.box == pytest.approx(background.box, abs=1 / 510)
    assert encode_background(decoded) == encode_background(background)


@pytest.mark.parametrize(
    ("index", "value", "text"),
    [(0, 256, "invalid photo number"), (1, 250, "outside the photo"), (4, 256, "outside the photo")],
)
def test_values_out_of_range_are_rejected(index: int, value: int, text: str) -> None:
    numbers, frame = msgpack.unpackb(encode_background(example_background()))
    numbers[index] = value
    with pytest.raises(ProtocolError, match=text):
        decode_background(msgpack.packb([numbers, frame]))


def test_an_image_that_is_no_vp8_frame_is_rejected() -> None:
    numbers, _ = msgpack.unpackb(encode_background(example_background()))
    with pytest.raises(ProtocolError, match="not a VP8 key frame"):
        decode_background(msgpack.packb([numbers, b"image"]))


@given(st.binary(max_size=80))
def test_any_bytes_give_a_background_or_protocol_error(data: bytes) -> None:
    try:
        decode_background(data)
    except ProtocolError:
        pass
