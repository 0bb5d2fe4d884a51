"""The texels of one group of faces, and what a painter may know of them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tools.assets.head.bake import rasterise
from tools.assets.head.part import Part


@dataclass(frozen=True)
class Texels:
    """N texels of the atlas.

    row, column : (N,) place in the picture; uv : (N, 2) in the atlas, v up; position, normal : (N, 3) cm, unit
    sky : (N,) ambient occlusion, 1 is open; mouth_ring, eye_ring : (N,) edge loops away from lip contact and lid
    """

    row: NDArray[np.int64]
    column: NDArray[np.int64]
    uv: NDArray[np.float64]
    position: NDArray[np.float32]
    normal: NDArray[np.float32]
    sky: NDArray[np.float32]
    mouth_ring: NDArray[np.float32]
    eye_ring: NDArray[np.float32]


def bake_texels(size: int, head: Part, group: str, attributes: NDArray[np.float64]) -> Texels:
    """Find the texels of a group.

    attributes : (V, 9) position, normal, sky, mouth ring, eye ring
    """
    part = Part(head.vertices, head.shapes, head.uvs, {group: head.groups[group]})
    values, mask = rasterise(size, head.uvs, part.triangles(), attributes)
    row, column = np.nonzero(mask)
    uv = np.stack([(column + 0.5) / size, 1 - (row + 0.5) / size], axis=1)
    found = values[mask]
    normal = found[:, 3:6] / np.maximum(np.linalg.norm(found[:, 3:6], axis=1, keepdims=True), 1e-6)
    return Texels(row, column, uv, found[:, :3], normal, found[:, 6], found[:, 7], found[:, 8])


def vertex_normals(vertices: NDArray[np.float64], triangles: NDArray[np.int64]) -> NDArray[np.float64]:
    """Return (V, 3) unit normals, the mean of the faces around each vertex by area."""
    a, b, c = (vertices[triangles[:, i]] for i in range(3))
    faces = np.cross(b - a, c - a)
    normals = np.zeros_like(vertices)
    for i in range(3):
        np.add.at(normals, triangles[:, i], faces)
    return np.asarray(normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12))
