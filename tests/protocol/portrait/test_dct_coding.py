import numpy as np
import pytest

from conf.protocol.codec.symbol_coder import SymbolReader, SymbolWriter
from conf.protocol.portrait.dct_coding import code_coefficient_planes, plane_shapes
from conf.protocol.portrait.probability_model import load_portrait_model


def test_tints_have_half_the_rows_and_columns() -> None:
    assert plane_shapes(96, 40) == [(5, 12, 64), (3, 6, 64), (3, 6, 64)]
    assert plane_shapes(9, 1) == [(1, 2, 64), (1, 1, 64), (1, 1, 64)]


@pytest.mark.parametrize("size", [(96, 96), (17, 33), (1, 1)])
def test_every_coefficient_comes_back(size: tuple[int, int]) -> None:
    rng = np.random.default_rng(size[0])
    blocks = load_portrait_model().blocks
    sent = [rng.integers(-30, 31, shape) * (rng.random(shape) < 0.1) for shape in plane_shapes(*size)]
    writer = SymbolWriter(rd_lambda=0)
    code_coefficient_planes(writer, blocks, sent)
    got = code_coefficient_planes(SymbolReader(writer.finish()), blocks, [np.zeros_like(plane) for plane in sent])
    for mine, theirs in zip(sent, got, strict=True):
        np.testing.assert_array_equal(theirs, mine)


def test_empty_blocks_cost_less_than_a_bit() -> None:
    writer = SymbolWriter(rd_lambda=0)
    planes = [np.zeros(shape) for shape in plane_shapes(96, 96)]
    code_coefficient_planes(writer, load_portrait_model().blocks, planes)
    assert writer.bits < sum(plane.shape[0] * plane.shape[1] for plane in planes)
