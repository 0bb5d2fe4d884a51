"""DCT blocks as symbols: which blocks are not empty, the last coefficient of each, and the coefficients.

The brightness plane comes first, then the two chroma planes with half its rows and columns; blocks in raster order, the
coefficients of each in order of rising frequency. The probability that a block is empty depends on its left and upper
neighbours.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from conf.protocol.codec.symbol_coder import SymbolCoder
from conf.protocol.portrait.probability_model import BlockModel, difference_tables

BLOCK = 8  # px
Planes = Sequence[NDArray[Any]]
_DEADZONE = 0.6  # steps: a smaller coefficient neither makes a block non-empty nor extends it


def plane_shapes(width: int, height: int, /) -> list[tuple[int, int, int]]:
    """Return (rows, columns, 64) of the three planes of an image of `width` x `height` pixels."""
    sides = [(height, width)] + [(-(-height // 2), -(-width // 2))] * 2
    return [(-(-rows // BLOCK), -(-columns // BLOCK), BLOCK * BLOCK) for rows, columns in sides]


def code_coefficient_planes(coder: SymbolCoder, model: BlockModel, planes: Planes, /) -> list[NDArray[np.int64]]:
    """Code three planes of blocks (rows, columns, 64), in steps. Raises ProtocolError when reading."""
    kinds = list(zip(*model.tables(), strict=True))
    return [_code_plane(coder, *kinds[kind], plane) for kind, plane in zip((0, 1, 1), planes, strict=True)]


def _code_plane(
    coder: SymbolCoder, coded: list[list[int]], last: list[int], scales: list[int], plane: NDArray[Any]
) -> NDArray[np.int64]:
    tables = difference_tables()
    rows, columns, size = plane.shape
    ends = np.where(np.abs(plane) >= _DEADZONE, np.arange(1, size + 1), 0).max(axis=2).tolist()
    result = np.zeros(plane.shape, np.int64)
    nonempty = [[0] * (columns + 1) for _ in range(rows + 1)]  # one more, so that index -1 is empty too
    for y in range(rows):
        for x in range(columns):
            end = ends[y][x]
            neighbours = nonempty[y - 1][x] + nonempty[y][x - 1]
            nonempty[y][x] = coder.symbol(coded[neighbours], int(end > 0))
            if nonempty[y][x]:
                count = coder.symbol(last, max(end - 1, 0)) + 1
                targets = zip(scales[:count], plane[y, x].tolist(), strict=False)
                result[y, x, :count] = [coder.number(tables, scale, target) for scale, target in targets]
    return result
