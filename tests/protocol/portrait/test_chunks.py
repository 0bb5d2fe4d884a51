import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.errors import ProtocolError
from conf.protocol.portrait.chunks import (
    MAX_OBJECT_BYTES,
    Ack,
    Chunk,
    chunk_count,
    decode_ack,
    decode_chunk,
    encode_ack,
    encode_chunk,
)

NUMBERS = st.integers(0, 65535)


def test_a_chunk_is_decoded_as_it_was_encoded() -> None:
    chunk = Chunk(513, 80, 2, 170, b"x" * 10)
    assert encode_chunk(chunk).hex() == "0201140200aa" + "78" * 10
    assert decode_chunk(encode_chunk(chunk)) == chunk


@pytest.mark.parametrize(
    "chunk",
    [
        Chunk(0, 80, 1, 160, b"x" * 80),  # the last chunk is full
        Chunk(0, 52, 236, MAX_OBJECT_BYTES, b"x" * 16),  # as many as fit an object of the largest size
        Chunk(0, 4, 254, 1017, b"x"),  # the 255th chunk
        Chunk(65535, 1020, 0, 1, b"x"),
    ],
)
def test_chunks_at_the_limits_are_valid(chunk: Chunk) -> None:
    assert decode_chunk(encode_chunk(chunk)) == chunk


@pytest.mark.parametrize(("object_size", "size", "count"), [(1, 80, 1), (80, 80, 1), (81, 80, 2), (160, 80, 2)])
def test_chunk_count(object_size: int, size: int, count: int) -> None:
    assert chunk_count(object_size, size) == count


@pytest.mark.slow
@given(NUMBERS, st.lists(NUMBERS, max_size=32), st.dictionaries(NUMBERS, st.sets(st.integers(0, 250)), max_size=4))
def test_an_ack_is_decoded_as_it_was_encoded(
    receiver_id: int, complete: list[int], partial: dict[int, set[int]]
) -> None:
    ack = Ack(receiver_id, tuple(complete), tuple((n, frozenset(i)) for n, i in partial.items()))
    assert decode_ack(encode_ack(ack)) == ack


@pytest.mark.parametrize(
    ("ack", "hexes"),
    [
        (Ack(0x1234, (), ()), "123400"),
        (Ack(1, (2, 0x0304), ()), "00010200020304"),
        (Ack(1, (), ((5, frozenset({0, 9})), (6, frozenset({7})))), "000100" + "00050a0102" + "00060880"),
        (Ack(1, (), ((5, frozenset()),)), "000100" + "00050100"),
        (Ack(1, (2,), ((5, frozenset({8})),)), "0001010002" + "0005090001"),
    ],
)
def test_acks_in_bytes_and_every_truncation_of_them(ack: Ack, hexes: str) -> None:
    data = encode_ack(ack)
    assert data.hex() == hexes and decode_ack(data) == ack
    complete = {len(encode_ack(Ack(ack.receiver_id, ack.complete, ack.partial[:n]))) for n in range(len(ack.partial))}
    for size in set(range(len(data))) - complete:
        with pytest.raises(ProtocolError, match="cut off"):
            decode_ack(data[:size])


@pytest.mark.parametrize("hexes", ["000021" + "0001" * 33, "000000" + "00010101" * 5])
def test_an_ack_of_too_many_objects_is_rejected(hexes: str) -> None:
    with pytest.raises(ProtocolError, match="too many objects"):
        decode_ack(bytes.fromhex(hexes))


@given(st.binary(max_size=400))
def test_any_bytes_are_decoded_or_a_protocol_error(data: bytes) -> None:
    for decode in (decode_chunk, decode_ack):
        try:
            decode(data)
        except ProtocolError:
            pass


@pytest.mark.parametrize(
    ("chunk", "reason"),
    [
        (Chunk(1, 80, 0, MAX_OBJECT_BYTES + 1, b"x" * 80), "out of range"),
        (Chunk(1, 80, 0, 0, b"x" * 80), "out of range"),
        (Chunk(1, 0, 0, 80, b"x" * 80), "out of range"),
        (Chunk(1, 4, 0, 1021, b"x" * 4), "beyond the end"),  # 256 chunks
        (Chunk(1, 80, 3, 170, b"x" * 10), "beyond the end"),
        (Chunk(1, 80, 2, 170, b"x" * 11), "wrong length"),
        (Chunk(1, 80, 2, 170, b"x" * 9), "wrong length"),
        (Chunk(1, 80, 1, 170, b"x" * 10), "wrong length"),
        (Chunk(1, 80, 0, 170, b"x" * 79), "wrong length"),
        (Chunk(1, 80, 0, 170, b""), "without data"),
    ],
)
def test_inconsistent_chunks_are_rejected(chunk: Chunk, reason: str) -> None:
    with pytest.raises(ProtocolError, match=reason):
        decode_chunk(encode_chunk(chunk))
