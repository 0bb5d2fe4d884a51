import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.errors import ProtocolError
from conf.protocol.portrait.chunks import (
    MAX_OBJECT,
    Ack,
    Chunk,
    decode_answer,
    decode_piece,
    encode_answer,
    encode_piece,
)

NUMBERS = st.integers(0, 65535)


def test_a_piece_survives() -> None:
    piece = Chunk(513, 80, 2, 170, b"x" * 10)
    assert encode_piece(piece).hex() == "0201140200aa" + "78" * 10
    assert decode_piece(encode_piece(piece)) == piece


@given(NUMBERS, st.lists(NUMBERS, max_size=32), st.dictionaries(NUMBERS, st.sets(st.integers(0, 250)), max_size=4))
def test_an_answer_survives(token: int, finished: list[int], unfinished: dict[int, set[int]]) -> None:
    answer = Ack(token, tuple(finished), tuple((n, frozenset(i)) for n, i in unfinished.items()))
    assert decode_answer(encode_answer(answer)) == answer


@given(st.binary(max_size=400))
def test_any_bytes_are_data_or_the_one_error(data: bytes) -> None:
    for decode in (decode_piece, decode_answer):
        try:
            decode(data)
        except ProtocolError:
            pass


@pytest.mark.parametrize(
    ("piece", "why"),
    [
        (Chunk(1, 80, 0, MAX_OBJECT + 1, b"x" * 80), "too much"),
        (Chunk(1, 0, 0, 80, b"x" * 80), "of nothing"),
        (Chunk(1, 4, 0, 12000, b"x" * 4), "beyond the end"),
        (Chunk(1, 80, 3, 170, b"x" * 10), "beyond the end"),
        (Chunk(1, 80, 2, 170, b"x" * 11), "wrong length"),
        (Chunk(1, 80, 0, 170, b"x" * 79), "wrong length"),
        (Chunk(1, 80, 0, 170, b""), "without data"),
    ],
)
def test_totals_that_do_not_fit_are_refused(piece: Chunk, why: str) -> None:
    with pytest.raises(ProtocolError, match=why):
        decode_piece(encode_piece(piece))
