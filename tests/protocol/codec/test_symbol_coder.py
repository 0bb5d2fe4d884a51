"""Numbers as symbols: both directions agree, and a bargain is never dearer than the nearest number."""

from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.errors import ProtocolError
from conf.protocol.codec.model import load_models
from conf.protocol.codec.range_coder import TOTAL
from conf.protocol.codec.symbol_coder import (
    ESCAPE,
    LIMIT,
    MAX_TABLE_MAGNITUDE,
    SymbolReader,
    SymbolWriter,
    Tables,
    uniform_table,
    weighted_table,
)

TABLES = load_models()["live"].tables
SCALES = st.integers(0, TABLES.last + 32)
WANTED = st.one_of(st.floats(-4, 4), st.floats(-300, 300), st.floats(-2.0 * LIMIT, 2.0 * LIMIT))


@given(st.lists(st.tuples(SCALES, WANTED), max_size=40))
def test_numbers_come_back(wanted: list[tuple[int, float]]) -> None:
    writer = SymbolWriter(rd_lambda=0.1)
    written = [writer.number(TABLES, scale, number) for scale, number in wanted]
    reader = SymbolReader(writer.finish())
    assert [reader.number(TABLES, scale) for scale, _ in wanted] == written
    reader.finish()


@given(SCALES, st.floats(-LIMIT, LIMIT))
def test_what_is_written_lies_within_a_step_and_not_further_out(scale: int, wanted: float) -> None:
    written = SymbolWriter(rd_lambda=0.1).number(TABLES, scale, wanted)
    assert abs(written - wanted) <= 1
    assert abs(written) <= abs(round(wanted))


@given(SCALES, st.floats(-LIMIT, LIMIT))
def test_without_trade_the_nearest_is_written(scale: int, wanted: float) -> None:
    assert SymbolWriter(rd_lambda=0.0).number(TABLES, scale, wanted) == round(wanted)


def test_bits_spent_are_the_tables_information() -> None:
    writer = SymbolWriter(rd_lambda=0.0)
    for number in [0, 1, -1, 3, 0, 0, 25, -400]:
        writer.number(TABLES, 12, number)
    assert writer.bits / 8 - 1 < len(writer.finish()) < writer.bits / 8 + 1


def test_every_table_is_sharpest_at_zero() -> None:
    for cost in TABLES.cost:
        assert min(cost) == cost[MAX_TABLE_MAGNITUDE]


def test_frequencies_must_be_positive_and_complete() -> None:
    with pytest.raises(ValueError, match="not positive"):
        Tables.from_frequencies([[TOTAL, *[0] * ESCAPE]])
    with pytest.raises(ValueError, match=f"sum to 42, not {TOTAL}"):
        Tables.from_frequencies([[1] * (ESCAPE + 1)])


def test_flat_and_weighted_tables_are_whole() -> None:
    for table in (uniform_table(50), weighted_table([3, 1, 0.001])):
        assert table[0] == 0
        assert table[-1] == TOTAL
        assert all(a < b for a, b in pairwise(table))


def test_an_escape_of_no_length_is_refused() -> None:
    writer = SymbolWriter(rd_lambda=0.0)
    writer.symbol(TABLES.cumulative[5], ESCAPE)
    writer.symbol(uniform_table(16), 0)
    with pytest.raises(ProtocolError, match="escape of an impossible length"):
        SymbolReader(writer.finish()).number(TABLES, 5)
