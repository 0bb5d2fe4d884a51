"""A part of the head: vertices with 52 blendshapes, and faces in named groups with coordinates in the atlas."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

SHAPE_COUNT = 52
NONE = -1  # fourth corner of a triangle


@dataclass(frozen=True)
class Part:
    """Vertices shared by one or more groups of faces.

    vertices : (V, 3) cm; shapes : (52, V, 3) cm; uvs : (T, 2) in the atlas, v up
    groups : name -> (F, 4, 2) corners (vertex, uv); the fourth corner of a triangle is NONE
    """

    vertices: NDArray[np.float64]
    shapes: NDArray[np.float64]
    uvs: NDArray[np.float64]
    groups: Mapping[str, NDArray[np.int64]]

    def triangles(self) -> NDArray[np.int64]:
        """Return the (F, 3, 2) corners of all groups, quads split."""
        return split_quads(np.concatenate(list(self.groups.values())))


def split_quads(corners: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the (F, 3, 2) corners of triangles for (Q, 4, 2) corners of quads and triangles."""
    second = corners[corners[:, 3, 0] != NONE][:, [0, 2, 3]]
    return np.concatenate([corners[:, :3], second])


@dataclass(frozen=True)
class Frame:
    """A rectangle of the atlas, in atlas coordinates 0 to 1, v up."""

    left: float
    bottom: float
    width: float
    height: float

    def map_into(self, uvs: NDArray[np.float64]) -> NDArray[np.float64]:
        """Map (T, 2) coordinates of the unit square into the rectangle."""
        return np.array([self.left, self.bottom]) + uvs * [self.width, self.height]


FRAMES = {
    "face": Frame(0.003, 0.404, 0.994, 0.593),
    "neck": Frame(0.003, 0.253, 0.344, 0.144),
    "shirt": Frame(0.003, 0.103, 0.344, 0.144),
    "teeth": Frame(0.003, 0.003, 0.344, 0.094),
    "hair": Frame(0.353, 0.003, 0.294, 0.394),
    "lock": Frame(0.653, 0.203, 0.194, 0.194),
    "fall": Frame(0.903, 0.003, 0.094, 0.194),
    "eye": Frame(0.853, 0.253, 0.144, 0.144),
    "mouth": Frame(0.653, 0.053, 0.144, 0.144),
    "tongue": Frame(0.803, 0.103, 0.094, 0.094),
    "lashes": Frame(0.853, 0.203, 0.144, 0.044),
}


def join(parts: Sequence[Part]) -> Part:
    """Join parts into one, vertices in the order of the parts."""
    groups: dict[str, NDArray[np.int64]] = {}
    vertex, uv = 0, 0
    for part in parts:
        for name, corners in part.groups.items():
            moved = np.where(corners == NONE, NONE, corners + np.array([vertex, uv]))
            groups[name] = np.concatenate([groups[name], moved]) if name in groups else moved
        vertex, uv = vertex + len(part.vertices), uv + len(part.uvs)
    return Part(
        np.concatenate([p.vertices for p in parts]),
        np.concatenate([p.shapes for p in parts], axis=1),
        np.concatenate([p.uvs for p in parts]),
        groups,
    )


def grid(rows: int, columns: int, *, closed: str = "") -> NDArray[np.int64]:
    """Return the (F, 4, 2) corners of a grid of vertices in row order.

    closed : "columns" if the last column connects to the first; the uv grid then has one more column
    """
    wrap = closed == "columns"
    spans = columns if wrap else columns - 1
    row, column = (a.ravel() for a in np.meshgrid(np.arange(rows - 1), np.arange(spans), indexing="ij"))
    uv_columns = columns + 1 if wrap else columns

    def corner(down: int, right: int) -> NDArray[np.int64]:
        vertex = (row + down) * columns + (column + right) % columns
        return np.stack([vertex, (row + down) * uv_columns + column + right], axis=-1)

    return np.stack([corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)], axis=1)


def rigid(vertices: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the (52, V, 3) zero blendshapes of a rigid part."""
    return np.zeros((SHAPE_COUNT, len(vertices), 3))
