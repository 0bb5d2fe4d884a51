"""Rasterise parts into the atlas: which point of the head each texel shows."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class TexelMap:
    """What the texels of the atlas show.

    values : (S, S, C) float32, vertex attributes interpolated; row 0 is the top of the picture
    part : (S, S) int8, index of the group drawn there, -1 where nothing is
    """

    values: NDArray[np.float32]
    part: NDArray[np.int8]


def rasterise(
    size: int, uvs: NDArray[np.float64], corners: NDArray[np.int64], attributes: NDArray[np.float64], /
) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
    """Interpolate vertex attributes over the triangles' texels.

    uvs : (T, 2); corners : (F, 3, 2) vertex and uv indices; attributes : (V, C)
    Returns (size, size, C) values and the (size, size) mask of texels whose centre lies in a triangle.
    """
    values = np.zeros((size, size, attributes.shape[1]), dtype=np.float32)
    mask = np.zeros((size, size), dtype=bool)
    pixels = uvs * [size, -size] + [0, size] - 0.5
    triangles = pixels[corners[..., 1]]
    for triangle, vertices in zip(triangles, corners[..., 0], strict=True):
        _fill(triangle, attributes[vertices], values, mask)
    return values, mask


def _fill(
    triangle: NDArray[np.float64],
    attributes: NDArray[np.float64],
    values: NDArray[np.float32],
    mask: NDArray[np.bool_],
) -> None:
    size = len(mask)
    low = np.maximum(np.floor(triangle.min(axis=0)).astype(int), 0)
    high = np.minimum(np.ceil(triangle.max(axis=0)).astype(int) + 1, size)
    (ax, ay), (bx, by), (cx, cy) = triangle
    area = (bx - ax) * (cy - ay) - (cx - ax) * (by - ay)
    if area == 0 or (high <= low).any():
        return
    x, y = np.arange(low[0], high[0])[None, :], np.arange(low[1], high[1])[:, None]
    b = ((x - ax) * (cy - ay) - (cx - ax) * (y - ay)) / area
    c = ((bx - ax) * (y - ay) - (x - ax) * (by - ay)) / area
    inside = (b >= -1e-6) & (c >= -1e-6) & (b + c <= 1 + 1e-6)
    weights = np.stack([1 - b - c, b, c], axis=-1)[inside]
    window = slice(low[1], high[1]), slice(low[0], high[0])
    values[window][inside] = weights @ attributes
    mask[window] |= inside
