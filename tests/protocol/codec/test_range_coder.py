"""The range coder: symbols are read as they were written, in hardly more bytes than their information."""

from collections.abc import Sequence
from math import log2

import constriction
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.errors import ProtocolError
from conf.protocol.codec.range_coder import TOTAL, RangeDecoder, RangeEncoder
from tests.protocol.independent_decoder import Range

Message = list[tuple[tuple[int, ...], int]]


@st.composite
def messages(draw: st.DrawFn) -> Message:
    """Symbols, each with the table that it is coded with."""
    cuts = st.sets(st.integers(1, TOTAL - 1), min_size=1, max_size=12)
    tables = draw(st.lists(cuts, max_size=60))
    cumulative = [(0, *sorted(table), TOTAL) for table in tables]
    return [(table, draw(st.integers(0, len(table) - 2))) for table in cumulative]


def encoded(message: Sequence[tuple[Sequence[int], int]]) -> bytes:
    encoder = RangeEncoder()
    for cumulative, symbol in message:
        encoder.write(cumulative, symbol)
    return encoder.finish()


def information(message: Message) -> float:
    """Return the bytes that an ideal coder would need."""
    return -sum(log2((table[symbol + 1] - table[symbol]) / TOTAL) for table, symbol in message) / 8


@pytest.mark.slow
@given(messages())
def test_symbols_are_read_as_they_were_written(message: Message) -> None:
    decoder = RangeDecoder(encoded(message))
    assert [decoder.read(table) for table, _ in message] == [symbol for _, symbol in message]
    decoder.finish()


@pytest.mark.parametrize("seed", range(30))
def test_random_messages_are_read_and_padded_ones_refused(seed: int) -> None:
    rng = np.random.default_rng(seed)
    tables = [(0, *sorted(rng.choice(np.arange(1, TOTAL), rng.integers(1, 12), False).tolist()), TOTAL)] * 2 * seed
    message = [(table, int(rng.integers(0, len(table) - 1))) for table in tables]
    payload = encoded(message)
    string = Range(payload)
    assert [string.symbol(list(table)) for table, _ in message] == [symbol for _, symbol in message]
    assert string.end() == payload
    decoder = RangeDecoder(payload)
    assert [decoder.read(table) for table, _ in message] == [symbol for _, symbol in message]
    decoder.finish()
    for more in (b"\0", b"\1"):
        padded = RangeDecoder(payload + more)
        with pytest.raises(ProtocolError, match=r"cut short or padded|outside its tables"):
            for table, _ in message:
                padded.read(table)
            padded.finish()


@pytest.mark.slow
@given(messages())
def test_the_independent_decoder_reads_the_symbols(message: Message) -> None:
    payload = encoded(message)
    string = Range(payload)
    assert [string.symbol(list(table)) for table, _ in message] == [symbol for _, symbol in message]
    assert string.end() == payload


def test_the_independent_decoder_reads_a_long_message() -> None:
    """Rounding of the width accumulates, so that another precision is noticed."""
    rng = np.random.default_rng(4)
    table = (0, 9000, 9001, 20000, 32000, TOTAL)
    message = [(table, int(symbol)) for symbol in rng.integers(0, 5, 400)]
    payload = encoded(message)
    string = Range(payload)
    assert [string.symbol(list(table)) for table, _ in message] == [symbol for _, symbol in message]
    assert string.end() == payload


def test_likely_symbols_take_no_bytes() -> None:
    assert encoded([]) == b""
    assert encoded([((0, TOTAL - 1, TOTAL), 0)] * 50) == b""
    assert encoded([((0, 1, TOTAL), 1)] * 50) == b"\x01"
    assert encoded([((0, 1, TOTAL), 0)] * 3 + [((0, 1, TOTAL), 1)]) == b"\0\0\0\0\0\1"


def test_a_payload_above_all_symbols_is_rejected() -> None:
    """Integer division leaves a rest of the interval without a symbol."""
    decoder = RangeDecoder(b"\xff" * 8)
    with pytest.raises(ProtocolError, match="outside its tables"):
        for _ in range(4):
            decoder.read((0, 1, TOTAL))


@pytest.mark.slow
@given(messages())
def test_at_most_a_byte_more_than_the_information(message: Message) -> None:
    assert len(encoded(message)) <= information(message) + 1.001


@pytest.mark.slow
@given(messages(), st.binary(min_size=1, max_size=3))
def test_a_padded_payload_is_rejected(message: Message, more: bytes) -> None:
    decoder = RangeDecoder(encoded(message) + more)
    with pytest.raises(ProtocolError, match=r"cut short or padded|outside its tables"):
        for table, _ in message:
            decoder.read(table)
        decoder.finish()


@pytest.mark.slow
@given(st.binary(max_size=12), messages())
def test_any_bytes_give_symbols_or_protocol_error(data: bytes, message: Message) -> None:
    decoder = RangeDecoder(data)
    try:
        for table, _ in message:
            assert 0 <= decoder.read(table) < len(table) - 1
        decoder.finish()
    except ProtocolError:
        pass


def test_a_long_message_costs_what_constriction_needs() -> None:
    random = np.random.default_rng(1)
    chances = np.array([0.62, 0.2, 0.1, 0.05, 0.03])
    symbols = random.choice(len(chances), size=4000, p=chances).astype(np.int32)
    cumulative: Sequence[int] = [0, *np.rint(np.cumsum(chances) * TOTAL).astype(int).tolist()]
    ours = len(encoded([(tuple(cumulative), symbol) for symbol in symbols.tolist()]))
    reference = constriction.stream.queue.RangeEncoder()
    reference.encode(symbols, constriction.stream.model.Categorical(chances, perfect=False))
    theirs = reference.get_compressed().nbytes
    assert ours <= theirs * 1.002 + 1


def test_short_messages_cost_far_less_than_with_constriction() -> None:
    """The reason for a range coder of our own: theirs ends on a 32-bit word."""
    random = np.random.default_rng(2)
    chances = np.array([0.62, 0.2, 0.1, 0.05, 0.03])
    cumulative = (0, *np.rint(np.cumsum(chances) * TOTAL).astype(int).tolist())
    model = constriction.stream.model.Categorical(chances, perfect=False)
    ours = theirs = 0
    for _ in range(200):
        symbols = random.choice(len(chances), size=26, p=chances).astype(np.int32)
        ours += len(encoded([(cumulative, symbol) for symbol in symbols.tolist()]))
        reference = constriction.stream.queue.RangeEncoder()
        reference.encode(symbols, model)
        theirs += reference.get_compressed().nbytes
    assert ours < theirs - 200  # a byte a message at least
