"""Objects of a portrait: the first byte is the kind, and any bytes give an object or ProtocolError."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.errors import ProtocolError
from conf.protocol.portrait.objects import PortraitObject, decode_object, encode_object
from conf.protocol.portrait.photo import NeutralPoseUpdate
from tests.support.portrait_objects import example_background, example_patch, example_photo, example_view

UPDATE = NeutralPoseUpdate(1, example_photo().neutral, (6.4, 5.0, 2.5, 5.2, 0.9))
OBJECTS: list[PortraitObject] = [example_photo(), UPDATE, example_patch(), example_view(), example_background()]
BYTES = [encode_object(portrait_object) for portrait_object in OBJECTS]


@pytest.mark.slow
def test_the_first_byte_is_the_kind() -> None:
    for kind, portrait_object in enumerate(OBJECTS):
        data = encode_object(portrait_object)
        assert data[0] == kind
        decoded = decode_object(data)
        assert type(decoded) is type(portrait_object)
        assert encode_object(decoded) == data


@pytest.mark.parametrize("data", [b"", b"\5" + BYTES[0][1:], b"\xff"])
def test_an_unknown_kind_is_rejected(data: bytes) -> None:
    with pytest.raises(ProtocolError, match="an object of unknown kind"):
        decode_object(data)


@pytest.mark.slow
@given(
    st.sampled_from(BYTES),
    st.lists(st.tuples(st.integers(0, 2000), st.integers(0, 255)), max_size=6),
    st.integers(0, 3000),
)
def test_mutations_and_truncations_give_an_object_or_protocol_error(
    data: bytes, changes: list[tuple[int, int]], length: int
) -> None:
    mutated = bytearray(data)
    for position, value in changes:
        mutated[position % len(mutated)] = value
    try:
        decode_object(bytes(mutated[:length]))
    except ProtocolError:
        pass


@given(st.binary(max_size=200))
def test_any_bytes_give_an_object_or_protocol_error(data: bytes) -> None:
    try:
        decode_object(data)
    except ProtocolError:
        pass
