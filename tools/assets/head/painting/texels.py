"""Find the texels of one group of faces and interpolate the vertex attributes for its painter."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tools.assets.head.part import Part


@dataclass(frozen=True)
class Texels:
    """N texels of the atlas.

    row, column : (N,) position in the atlas, row 0 on top; uv : (N, 2) in the atlas, v up; position : (N, 3) cm
    normal : (N, 3) unit; sky : (N,) ambient occlusion, 1 is unoccluded
    mouth_ring, eye_ring : (N,) number of edges to the mouth cavity and to the eye socket
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
    """Return the texels of a group.

    attributes : (V, 9) position, normal, sky, mouth ring, eye ring
    """
    part = Part(head.vertices, head.shapes, head.uvs, {group: head.groups[group]})
    values, mask = rasterise(size, head.uvs, part.triangles(), attributes)
    row, column = np.nonzero(mask)
    uv = np.stack([(column + 0.5) / size, 1 - (row + 0.5) / size], axis=1)
    texels = values[mask]
    normal = texels[:, 3:6] / np.maximum(np.linalg.norm(texels[:, 3:6], axis=1, keepdims=True), 1e-6)
    return Texels(row, column, uv, texels[:, :3], normal, texels[:, 6], texels[:, 7], texels[:, 8])


def vertex_normals(vertices: NDArray[np.float64], triangles: NDArray[np.int64]) -> NDArray[np.float64]:
    """Return (V, 3) unit normals: of the faces around each vertex the mean, weighted by area."""
    a, b, c = (vertices[triangles[:, i]] for i in range(3))
    faces = np.cross(b - a, c - a)
    normals = np.zeros_like(vertices)
    for i in range(3):
        np.add.at(normals, triangles[:, i], faces)
    return np.asarray(normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12))


def rasterise(
    size: int, uvs: NDArray[np.float64], corners: NDArray[np.int64], attributes: NDArray[np.float64], /
) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
    """Interpolate vertex attributes at the texels of triangles.

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
    triangle: NDArray[np.float64], attributes: NDArray[np.float64], values: NDArray[np.float32], mask: NDArray[np.bool_]
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
