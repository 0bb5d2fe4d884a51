"""DCT blocks as symbols."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from conf.protocol.codec.symbol_coder import SymbolReader, SymbolWriter
from conf.protocol.portrait.dct_coding import code_coefficient_planes, plane_shapes
from conf.protocol.portrait.probability_model import load_portrait_model

BLOCKS = load_portrait_model().blocks


class FakeCoder:
    """A coder that records the tables and scales it is called with."""

    def __init__(self) -> None:
        self.tables: list[list[int]] = []
        self.scales: list[int] = []

    def symbol(self, cumulative: Sequence[int], value: int) -> int:
        """Record the table."""
        self.tables.append(list(cumulative))
        return value

    def number(self, tables: object, scale: int, target: float) -> int:
        """Record the scale."""
        self.scales.append(scale)
        return round(target)


def code(planes: list[NDArray[np.float64]]) -> tuple[FakeCoder, list[NDArray[np.int64]]]:
    """Return a recording coder and what was coded."""
    coder: Any = FakeCoder()
    return coder, code_coefficient_planes(coder, BLOCKS, planes)


def test_chroma_planes_have_half_the_rows_and_columns() -> None:
    assert plane_shapes(96, 40) == [(5, 12, 64), (3, 6, 64), (3, 6, 64)]
    assert plane_shapes(9, 1) == [(1, 2, 64), (1, 1, 64), (1, 1, 64)]
    assert plane_shapes(17, 33) == [(5, 3, 64), (3, 2, 64), (3, 2, 64)]
    assert plane_shapes(16, 8) == [(1, 2, 64), (1, 1, 64), (1, 1, 64)]


@pytest.mark.parametrize("size", [(96, 96), (17, 33), (1, 1)])
def test_every_coefficient_is_read_as_it_was_written(size: tuple[int, int]) -> None:
    rng = np.random.default_rng(size[0])
    sent = [rng.integers(-30, 31, shape) * (rng.random(shape) < 0.1) for shape in plane_shapes(*size)]
    writer = SymbolWriter(rd_lambda=0)
    code_coefficient_planes(writer, BLOCKS, sent)
    read = code_coefficient_planes(SymbolReader(writer.finish()), BLOCKS, [np.zeros_like(plane) for plane in sent])
    for expected, plane in zip(sent, read, strict=True):
        np.testing.assert_array_equal(plane, expected)


def test_coefficients_inside_the_dead_zone_are_not_coded() -> None:
    planes = [np.zeros(shape) for shape in plane_shapes(16, 8)]
    planes[0][0, 0, :5] = (0.59, -2.0, 0.59, -0.6, 0.59)
    planes[0][0, 1, :2] = (0.59, -0.59)
    coder, result = code(planes)
    np.testing.assert_array_equal(result[0][0, 0, :6], (1, -2, 1, -1, 0, 0))
    assert not result[0][0, 1].any()
    assert coder.scales == BLOCKS.coefficient_scale[0, :4].tolist()


def test_the_last_coefficient_of_a_block_is_coded_with_all_before_it() -> None:
    planes = [np.zeros(shape) for shape in plane_shapes(8, 8)]
    planes[1][0, 0, 63] = 9
    planes[2][0, 0, 0] = 1
    coder, result = code(planes)
    assert coder.scales == [*BLOCKS.coefficient_scale[1].tolist(), int(BLOCKS.coefficient_scale[1, 0])]
    np.testing.assert_array_equal(result[1], planes[1])
    last = [0, *np.cumsum(BLOCKS.last[1]).tolist()]
    assert [coder.tables[i] for i in (2, 4)] == [last, last]


def test_the_probability_of_an_empty_block_depends_on_its_neighbours() -> None:
    planes = [np.zeros(shape) for shape in plane_shapes(24, 16)]
    for position in ((0, 0), (0, 1), (1, 0)):
        planes[0][(*position, 0)] = 1
    coder, _ = code(planes)
    probabilities = [32768 - table[1] for table in coder.tables if len(table) == 3]
    #         no neighbours, left, left; above, left and above, left and above empty
    neighbours = [0, 1, 1, 1, 2, 0]
    assert probabilities == [BLOCKS.coded[0, n] for n in neighbours] + [BLOCKS.coded[1, 0]] * 4


def test_empty_blocks_cost_less_than_a_bit() -> None:
    writer = SymbolWriter(rd_lambda=0)
    planes = [np.zeros(shape) for shape in plane_shapes(96, 96)]
    code_coefficient_planes(writer, BLOCKS, planes)
    assert writer.bits < sum(plane.shape[0] * plane.shape[1] for plane in planes)
