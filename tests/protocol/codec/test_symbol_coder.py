"""Integers as symbols: both directions and the independent decoder agree, and the writer's choice is optimal."""

from itertools import pairwise
from math import log2

import numpy as np
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
from tests.protocol.independent_decoder import Range, live_tables, read_number, uniform, weighted

TABLES = load_models()["live"].tables
FREQUENCIES = live_tables()
LAST = len(FREQUENCIES) - 1
SCALES = st.integers(0, LAST + 32)
TARGETS = st.one_of(st.floats(-4, 4), st.floats(-300, 300), st.floats(-2.0 * LIMIT, 2.0 * LIMIT))
NUMBERS = [0, 1, -1, 2, -3, 19, 20, 21, -20, -21, 22, 51, -84, 1000, -4095, 4096, 8191, -8191]


@pytest.mark.slow
@given(st.lists(st.tuples(SCALES, TARGETS), max_size=40))
def test_numbers_are_read_as_they_were_written(targets: list[tuple[int, float]]) -> None:
    writer = SymbolWriter(rd_lambda=0.1)
    written = [writer.number(TABLES, scale, target) for scale, target in targets]
    reader = SymbolReader(writer.finish())
    assert [reader.number(TABLES, scale) for scale, _ in targets] == written
    reader.finish()


@pytest.mark.parametrize("scale", [0, LAST - 1, LAST, LAST + 1, LAST + 4, LAST + 5, LAST + 9, LAST + 30, LAST + 32])
def test_the_independent_decoder_reads_the_numbers(scale: int) -> None:
    writer = SymbolWriter(rd_lambda=0.0)
    assert [writer.number(TABLES, scale, number) for number in NUMBERS] == NUMBERS
    payload = writer.finish()
    string = Range(payload)
    assert [read_number(string, FREQUENCIES, scale) for _ in NUMBERS] == NUMBERS
    assert string.end() == payload


@pytest.mark.slow
@given(SCALES, st.floats(-LIMIT, LIMIT))
def test_the_written_number_is_within_a_step_and_not_further_from_zero(scale: int, target: float) -> None:
    written = SymbolWriter(rd_lambda=0.1).number(TABLES, scale, target)
    assert abs(written - target) <= 1
    assert abs(written) <= abs(round(target))


@pytest.mark.parametrize("scale", range(LAST + 1))
def test_the_written_number_has_the_lower_rate_distortion_cost(scale: int) -> None:
    bits = [15 - log2(frequency) for frequency in FREQUENCIES[scale]]
    for rd_lambda in (0.05, 0.3):
        for target in [*np.arange(-21, 21, 0.23).tolist(), 20.0, -20.0, 1.0, -1.0]:
            nearest = round(target)
            smaller = nearest - (nearest > 0) + (nearest < 0)
            candidates = [nearest, smaller] if abs(nearest) <= 20 else [nearest]
            cost = {n: (target - n) ** 2 + rd_lambda * bits[min(abs(n), 21) + 20] for n in candidates}
            assert SymbolWriter(rd_lambda=rd_lambda).number(TABLES, scale, target) == min(
                candidates, key=cost.__getitem__
            )


@given(SCALES, st.floats(-LIMIT, LIMIT) | st.sampled_from([1.5, -1.5, 7.5]))
def test_without_lambda_the_nearest_number_is_written(scale: int, target: float) -> None:
    assert SymbolWriter(rd_lambda=0.0).number(TABLES, scale, target) == round(target)


def test_numbers_are_clipped_to_13_bits() -> None:
    for target, written in ((8191.4, 8191), (8192, 8191), (-1e9, -8191), (8190, 8190)):
        assert SymbolWriter(rd_lambda=0.0).number(TABLES, LAST, target) == written


def test_bits_are_the_information_of_the_symbols_written() -> None:
    writer = SymbolWriter(rd_lambda=0.0)
    assert writer.bits == 0
    writer.number(TABLES, 12, 3)
    assert writer.bits == pytest.approx(15 - log2(FREQUENCIES[12][23]))
    for number in [0, 1, -1, 3, 0, 0, 25, -400]:
        writer.number(TABLES, 12, number)
    assert writer.bits / 8 - 1 < len(writer.finish()) < writer.bits / 8 + 1


def test_tables_hold_cumulative_frequencies_and_bits() -> None:
    frequencies = [[TOTAL // 2, TOTAL // 4, TOTAL // 4]]
    tables = Tables.from_frequencies(frequencies * 2)
    assert tables.cumulative == [[0, TOTAL // 2, TOTAL * 3 // 4, TOTAL]] * 2
    assert tables.cost == [[1, 2, 2]] * 2
    assert tables.last == 1


def test_every_trained_table_has_its_maximum_at_zero() -> None:
    for cost in TABLES.cost:
        assert min(cost) == cost[MAX_TABLE_MAGNITUDE]


@pytest.mark.parametrize("zero", [0, -1])
def test_frequencies_must_be_positive_and_complete(zero: int) -> None:
    with pytest.raises(ValueError, match="not positive"):
        Tables.from_frequencies([[TOTAL - zero, zero]])
    with pytest.raises(ValueError, match=f"sum to 42, not {TOTAL}"):
        Tables.from_frequencies([[1] * (ESCAPE + 1)])


def test_uniform_and_weighted_tables_are_those_of_wire_md() -> None:
    for size in (1, 2, 48, 50, 96, 256):
        assert uniform_table(size) == uniform(size)
    examples: list[list[float]] = [[30, 2, 2], [1, 40], [3, 1, 0.001], [60, 15, 32, *(19 / n for n in range(3, 64))]]
    for weights in examples:
        table = weighted_table(weights)
        assert table == weighted(weights)
        assert all(a < b for a, b in pairwise(table))


@pytest.mark.parametrize(("length", "error"), [(0, "impossible length"), (14, "impossible length"), (13, None)])
def test_an_escape_of_impossible_length_is_rejected(length: int, error: str | None) -> None:
    writer = SymbolWriter(rd_lambda=0.0)
    for table, symbol in ((TABLES.cumulative[5], ESCAPE), (uniform_table(16), length), (uniform_table(2), 1)):
        writer.symbol(table, symbol)
    reader = SymbolReader(writer.finish())
    if error:
        with pytest.raises(ProtocolError, match=error):
            reader.number(TABLES, 5)
    else:
        assert reader.number(TABLES, 5) == -20 - 4096


def test_a_padded_payload_is_rejected() -> None:
    reader = SymbolReader(b"\1\2\3")
    with pytest.raises(ProtocolError, match="cut short or padded"):
        reader.finish()
