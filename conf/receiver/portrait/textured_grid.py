"""Textured grids that cover a part of the portrait: their triangles, and their colours, mixed in linear light."""

import numpy as np
from numpy.typing import NDArray

_LINEAR = (np.arange(256) / 255) ** 2.2

Image = NDArray[np.float64]


def grid_triangles(rows: int, columns: int, /) -> NDArray[np.int32]:
    """Return the triangles (F, 3) of a grid whose vertices are in order of rows."""
    a = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)).ravel()
    b, c, d = a + 1, a + columns, a + columns + 1
    return np.concatenate([np.column_stack([a, b, d]), np.column_stack([a, d, c])]).astype(np.int32)


def to_linear(pixels: NDArray[np.uint8], /) -> Image:
    """Return linear light, 0 to 1, of sRGB. Source: IEC 61966-2-1, approximated by a power of 2.2."""
    return np.asarray(_LINEAR[pixels])


def to_srgb(light: Image, /) -> NDArray[np.uint8]:
    """Return sRGB of linear light."""
    return np.asarray(np.rint(255 * np.clip(light, 0, 1) ** (1 / 2.2)), np.uint8)
