"""Blocks of coefficients to symbols: which are not empty, where each ends, and its numbers.

Brightness comes first, then the two tints with half its rows and columns; blocks from left to right and from above, the
coefficients of each with the lowest frequencies first. Whether the neighbours are empty says how likely a block is.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from conf.protocol.codec.symbol_coder import SymbolCoder
from conf.protocol.portrait.probability_model import BlockModel, difference_tables

BLOCK = 8  # px
Planes = Sequence[NDArray[Any]]
_DEADZONE = 0.6  # steps: a coefficient below that is no reason to tell a block, or to go on in one


def plane_shapes(width: int, height: int, /) -> list[tuple[int, int, int]]:
    """Return (rows, columns, 64) of the three planes of a picture."""
    sides = [(height, width)] + [(-(-height // 2), -(-width // 2))] * 2
    return [(-(-rows // BLOCK), -(-columns // BLOCK), BLOCK * BLOCK) for rows, columns in sides]


def code_coefficient_planes(coder: SymbolCoder, model: BlockModel, wanted: Planes, /) -> list[NDArray[np.int64]]:
    """Code three planes of blocks (rows, columns, 64), in steps. May raise ProtocolError."""
    coded, last, spread = model.tables()
    kinds = (0, 1, 1)
    return [_code_plane(coder, (coded[k], last[k], spread[k]), plane) for k, plane in zip(kinds, wanted, strict=True)]


def _code_plane(
    coder: SymbolCoder,
    model: tuple[list[list[int]], list[int], list[int]],
    wanted: NDArray[Any],
) -> NDArray[np.int64]:
    coded, last, spread = model
    tables = difference_tables()
    rows, columns, size = wanted.shape
    ends = np.where(np.abs(wanted) >= _DEADZONE, np.arange(1, size + 1), 0).max(axis=2).tolist()
    result = np.zeros(wanted.shape, np.int64)
    full = [[0] * (columns + 1) for _ in range(rows + 1)]  # one beyond, so that index -1 is empty too
    for y in range(rows):
        for x in range(columns):
            end = ends[y][x]
            full[y][x] = coder.symbol(coded[full[y - 1][x] + full[y][x - 1]], int(end > 0))
            if full[y][x]:
                count = coder.symbol(last, max(end - 1, 0)) + 1
                numbers = zip(spread[:count], wanted[y, x].tolist(), strict=False)
                result[y, x, :count] = [coder.number(tables, scale, want) for scale, want in numbers]
    return result
