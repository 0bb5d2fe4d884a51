"""Two rows of rounded teeth on an arch, with gums."""

import numpy as np
from numpy.typing import NDArray

from tools.assets.head.part import FRAMES, Part, grid, rigid

# Widths of the teeth from the middle outwards, cm: incisors, canine, premolars, molars.
_WIDTHS = {"upper": (0.86, 0.66, 0.76, 0.7, 0.68, 1.0), "lower": (0.54, 0.6, 0.68, 0.7, 0.72, 1.05)}
_HEIGHTS = {"upper": (1.0, 0.93, 0.99, 0.88, 0.8, 0.7), "lower": (0.8, 0.82, 0.9, 0.82, 0.76, 0.7)}
_ACROSS = np.array([0.0, 0.14, 0.5, 0.86])  # positions of the columns of a tooth, relative to its width
_ROUND = np.array([0.0, 0.75, 1.0, 0.75])  # height of each column above the gap between two teeth, relative
_EDGE = np.array([0.89, 0.985, 1.0, 0.985])  # relative length of each column

_GAP = 0.09  # depth of the gap between two teeth behind their front, cm

# Cross-section of a row: (height from the root of the gum, relative; distance inwards, cm), outside first.
_SECTION = np.array([(-0.75, 0.12), (-0.2, 0.0), (0.0, 0.03), (0.08, 0.0), (0.45, -0.05), (0.85, 0.02), (1.0, 0.12)])
_BACK = np.array([(0.97, 0.24), (0.5, 0.45), (-0.2, 0.6)])


def build_teeth(row: str, front: NDArray[np.float64], half_width: float, depth: float) -> Part:
    """Build one row.

    row : "upper" or "lower"; front : (3,) where gum and middle incisors meet; half_width, depth : of the arch, cm
    """
    position, height, roundness, edge = _columns(row)
    arch, outward = _along_arch(position, half_width, depth)
    section = np.concatenate([_SECTION, _BACK])
    down = -1.0 if row == "upper" else 1.0
    rows = []
    for level, inward in section:
        length = height * level * np.where(level > 0.5, edge, 1.0)
        gap = (1 - roundness) * _GAP * (level > 0)
        point = front + arch - outward * (inward + gap)[:, None]
        point[:, 1] += down * length
        rows.append(point)
    vertices = np.concatenate(rows)
    along = (position - position[0]) / (position[-1] - position[0])
    u = np.tile(along, len(section))
    v = np.repeat(np.linspace(1, 0, len(section)) * 0.5 + (0.5 if row == "upper" else 0.0), len(position))
    corners = grid(len(section), len(position))
    if row == "lower":
        corners = corners[:, ::-1]
    uvs = FRAMES["teeth"].map_into(np.stack([u, v], axis=1))
    return Part(vertices, rigid(vertices), uvs, {f"teeth_{row}": corners})


def _columns(row: str) -> tuple[NDArray[np.float64], ...]:
    """Return for each column its position along the arch, tooth height, roundness and edge length."""
    position, height, roundness, edge = [], [], [], []
    start = 0.0
    for width, tall in zip(_WIDTHS[row], _HEIGHTS[row], strict=True):
        position += list(start + _ACROSS * width)
        height += [tall] * len(_ACROSS)
        roundness += list(_ROUND)
        edge += list(_EDGE)
        start += width
    half = [np.array(x) for x in (position, height, roundness, edge)]
    mirrored = [np.concatenate([(-h if i == 0 else h)[:0:-1], h]) for i, h in enumerate(half)]
    return tuple(mirrored)


def _along_arch(
    position: NDArray[np.float64], half_width: float, depth: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return (C, 3) points at positions along the arch, relative to its front, and (C, 3) outward directions."""
    angle = np.linspace(-1.5, 1.5, 600)
    x, z = half_width * np.sin(angle), depth * (np.cos(angle) - 1)
    length = np.concatenate([[0], np.cumsum(np.hypot(np.diff(x), np.diff(z)))])
    length -= length[-1] / 2
    normal = np.stack([np.sin(angle) / half_width, np.zeros_like(angle), np.cos(angle) / depth], axis=1)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    points = np.stack([np.interp(position, length, x), 0 * position, np.interp(position, length, z)], axis=1)
    return points, np.stack([np.interp(position, length, n) for n in normal.T], axis=1)
