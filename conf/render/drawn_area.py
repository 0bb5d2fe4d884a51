"""Find the part of the image that a mesh covers, so that edges are searched for there only."""

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

Rectangle = tuple[int, int, int, int]  # left, bottom, width, height, pixels from the lower left corner

BANDS = 6  # a head is narrower than its shoulders
BORDER = 2  # pixels around the mesh that an edge touches
STRETCH = 1.25  # how much longer than on the neutral face an edge may be


def longest_edges(vertices: NDArray[np.floating], triangles: NDArray[np.integer]) -> NDArray[np.float32]:
    """Return (V,) float32 the length, cm, that no edge at a vertex exceeds when the face moves.

    vertices : (V, 3) of the neutral face, cm; triangles : (F, 3)
    """
    corners = vertices[triangles]
    lengths = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    longest = np.zeros(len(vertices), np.float32)
    for column in triangles.T:
        np.maximum.at(longest, column, lengths)
    return STRETCH * longest


def covered_bands(
    vertices: NDArray[np.floating], clip: NDArray[np.float64], size: tuple[int, int], *, edges: NDArray[np.float32]
) -> list[Rectangle]:
    """Return rectangles, one above the other, that contain the drawn triangles and little else.

    vertices : (V, 3) face axes, cm
    clip : (4, 4) from `conf.render.camera.clip_matrix`
    size : width and height of the image in pixels
    edges : (V,) from `longest_edges`: how far the triangles at a vertex reach from one band into the next, cm
    """
    width, height = size
    rows = clip[[0, 1, 3]].astype(np.float32)
    x, y, w = rows[:, :3] @ vertices.T.astype(np.float32, copy=False) + rows[:, 3:]
    if not len(w) or w.min() <= 0:  # behind the camera
        return [(0, 0, width, height)]
    x = (x / w + 1) * (width / 2)
    y = (y / w + 1) * (height / 2)
    borders = np.linspace(max(float(y.min()) - BORDER, 0.0), min(float(y.max()) + BORDER, height), BANDS + 1)
    reach = edges * (np.linalg.norm(rows[1, :3]) / w.min() * height / 2) + BORDER
    upper, lower = y + reach, y - reach
    bands: list[Rectangle] = []
    for low, high in pairwise(borders.tolist()):
        inside = x[(upper > low) & (lower < high)]
        if not len(inside):
            continue
        left, right = max(int(inside.min()) - BORDER, 0), min(int(inside.max()) + 1 + BORDER, width)
        bottom, top = round(low), round(high)
        if left < right and bottom < top:
            bands.append((left, bottom, right - left, top - bottom))
    return bands


def complement(bands: list[Rectangle], size: tuple[int, int]) -> list[Rectangle]:
    """Return rectangles that fill the image beside, below and above of bands that are sorted upwards."""
    width, height = size
    rest: list[Rectangle] = []
    row = 0
    for left, bottom, band_width, band_height in bands:
        rest.append((0, row, width, bottom - row))
        rest.append((0, bottom, left, band_height))
        rest.append((left + band_width, bottom, width - left - band_width, band_height))
        row = bottom + band_height
    rest.append((0, row, width, height - row))
    return [rectangle for rectangle in rest if rectangle[2] > 0 and rectangle[3] > 0]
