from dataclasses import replace

import msgpack
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.errors import ProtocolError
from conf.protocol.portrait.view import MAX_VIEWS, decode_view, encode_view
from tests.support.portrait_objects import example_view


def test_a_view_is_what_was_encoded() -> None:
    view = example_view()
    decoded = decode_view(encode_view(view))
    assert (decoded.photo_number, decoded.slot, decoded.frame) == (view.photo_number, view.slot, view.frame)
    np.testing.assert_allclose(decoded.box, view.box, atol=1 / 510)
    np.testing.assert_allclose(decoded.pose, view.pose, atol=2.5e-4)
    np.testing.assert_allclose(decoded.points, view.points, atol=0.0101)
    assert encode_view(decoded) == encode_view(view)


def test_a_view_in_no_slot_is_refused() -> None:
    with pytest.raises(ValueError, match=f"there is no slot {MAX_VIEWS} for a view"):
        encode_view(replace(example_view(), slot=MAX_VIEWS))


@pytest.mark.parametrize(
    ("index", "value", "text"),
    [
        (0, 256, "photo number or slot"),
        (1, MAX_VIEWS, "photo number or slot"),
        (2, 250, "outside the frame"),
        (5, 256, "outside the frame"),
        (3, -1, "outside the frame"),
        (6, 15_000, "impossible head pose"),
        (11, 3_000, "impossible head pose"),
    ],
)
def test_values_out_of_range_are_rejected(index: int, value: int, text: str) -> None:
    numbers, shape, frame = msgpack.unpackb(encode_view(example_view()))
    numbers[index] = value
    with pytest.raises(ProtocolError, match=text):
        decode_view(msgpack.packb([numbers, shape, frame]))


def test_an_image_that_is_no_vp8_frame_is_rejected() -> None:
    with pytest.raises(ProtocolError, match="not a VP8 key frame"):
        decode_view(encode_view(replace(example_view(), frame=b"image")))


@given(st.binary(max_size=120))
def test_any_bytes_give_a_view_or_protocol_error(data: bytes) -> None:
    try:
        decode_view(data)
    except ProtocolError:
        pass
