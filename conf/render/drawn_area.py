"""Find the part of the image that a mesh covers, so that edges are searched for there only."""

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

Rectangle = tuple[int, int, int, int]  # left, bottom, width, height, pixels from the lower left corner

BANDS = 4  # a head is narrower than its shoulders
OVERLAP = 0.25  # of a band's height: triangles reach from one band into the next
BORDER = 2  # pixels around the mesh that an edge touches


def covered_bands(vertices: NDArray[np.floating], clip: NDArray[np.float64], size: tuple[int, int]) -> list[Rectangle]:
    """Return rectangles, one above the other, that contain the drawn vertices and little else.

    vertices : (V, 3) face axes, cm
    clip : (4, 4) from `conf.render.camera.clip_matrix`
    size : width and height of the image in pixels
    """
    width, height = size
    rows = clip[[0, 1, 3]].astype(np.float32)
    x, y, w = rows[:, :3] @ vertices.T.astype(np.float32) + rows[:, 3:]
    if not len(w) or w.min() <= 0:  # behind the camera
        return [(0, 0, width, height)]
    x = (x / w + 1) * (width / 2)
    y = (y / w + 1) * (height / 2)
    edges = np.linspace(max(float(y.min()) - BORDER, 0.0), min(float(y.max()) + BORDER, height), BANDS + 1)
    overlap = OVERLAP * (edges[1] - edges[0]) + BORDER
    bands: list[Rectangle] = []
    for low, high in pairwise(edges.tolist()):
        inside = x[(y > low - overlap) & (y < high + overlap)]
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
