from hypothesis import given
from hypothesis import strategies as st

from conf.errors import ProtocolError
from conf.protocol.portrait import NeutralPoseUpdate, decode_object, encode_object
from tests.support.portrait_objects import example_patch, example_photo

THINGS = [example_photo(), example_patch(), NeutralPoseUpdate(1, example_photo().neutral, (6.4, 5.0, 2.5, 5.2, 0.9))]
BYTES = [encode_object(thing) for thing in THINGS]


def test_each_thing_comes_back_as_its_kind() -> None:
    for thing, data in zip(THINGS, BYTES, strict=True):
        assert type(decode_object(data)) is type(thing)


@given(
    st.sampled_from(BYTES),
    st.lists(st.tuples(st.integers(0, 2000), st.integers(0, 255)), max_size=6),
    st.integers(0, 3000),
)
def test_mutations_and_truncations_give_a_thing_or_the_one_error(
    data: bytes, changes: list[tuple[int, int]], length: int
) -> None:
    mutated = bytearray(data)
    for at, value in changes:
        mutated[at % len(mutated)] = value
    try:
        decode_object(bytes(mutated[:length]))
    except ProtocolError:
        pass


@given(st.binary(max_size=200))
def test_any_bytes_give_a_thing_or_the_one_error(data: bytes) -> None:
    try:
        decode_object(data)
    except ProtocolError:
        pass
