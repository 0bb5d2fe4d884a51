"""Find points on the surface of a mesh: the first hit of a viewing ray, and the nearest point."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from conf.face.mesh.winding import triangle_normals

_CHUNK = 1 << 21  # point-in-triangle tests at a time
_EDGE_TOLERANCE = 1e-12  # a point on an edge belongs to both triangles


@dataclass(frozen=True)
class RayHits:
    """The first hits of rays from the viewer along -z.

    points : (L, 3), nan for a miss
    triangles : (L,) index of the triangle hit, -1 for a miss
    """

    points: NDArray[np.float64]
    triangles: NDArray[np.intp]


def cast_clip_rays(
    points_2d: NDArray[np.floating],
    clip: NDArray[np.float64],
    vertices: NDArray[np.float64],
    triangles: NDArray[np.int32],
) -> NDArray[np.float64]:
    """Return the (L, 3) point of the mesh that is visible at each image position, nan for a miss.

    points_2d : (L, 2) image positions, -1 to 1, x right, y up
    clip : (4, 4) from a homogeneous column of the vertices' coordinates to clip coordinates
    vertices : (V, 3); triangles : (F, 3), visible from both sides
    """
    in_clip = vertices @ clip[:, :3].T + clip[:, 3]
    in_front = triangles[(in_clip[:, 3] > 0)[triangles].all(axis=1)]
    corners = in_clip[in_front]
    rays, hit, weights = _intersect(points_2d, corners[..., :3] / np.where(corners[..., 3:] > 0, corners[..., 3:], 1.0))
    weights = weights / corners[hit][..., 3]  # perspective-correct
    points = np.full((len(points_2d), 3), np.nan)
    points[rays] = np.einsum("hc,hci->hi", weights, vertices[in_front[hit]]) / weights.sum(axis=1, keepdims=True)
    return points


def cast_front_rays(
    points_2d: NDArray[np.float64], vertices: NDArray[np.float64], triangles: NDArray[np.int32]
) -> RayHits:
    """Return the first hits of rays along -z through x, y positions (L, 2) on a mesh (V, 3), (F, 3)."""
    points, found = np.full((len(points_2d), 3), np.nan), np.full(len(points_2d), -1, dtype=np.intp)
    rays, hit, weights = _intersect(points_2d, vertices[triangles] * [1.0, 1.0, -1.0])
    points[rays] = np.einsum("hc,hci->hi", weights, vertices[triangles[hit]])
    found[rays] = hit
    return RayHits(points, found)


def faces_viewer(points_2d: NDArray[np.float64], vertices: NDArray[np.float64], triangles: NDArray[np.int32]) -> bool:
    """Tell whether at least half of the triangles visible along -z at positions (L, 2) are counter-clockwise."""
    hits = cast_front_rays(points_2d, vertices, triangles).triangles
    normals = triangle_normals(vertices, triangles[hits[hits >= 0]])
    return bool((normals[:, 2] >= 0).sum() * 2 >= len(normals))


def nearest_points(
    points: NDArray[np.float64],
    directions: NDArray[np.float64],
    vertices: NDArray[np.float64],
    triangles: NDArray[np.int32],
    *,
    reach: float,
) -> NDArray[np.float64]:
    """Return the (n, 3) nearest point of the surface within reach of each point, nan if there is none.

    points : (n, 3); directions : (n, 3) unit vectors; only triangles whose normal is within 60 degrees of it count
    """
    corners, normals = vertices[triangles], triangle_normals(vertices, triangles)
    lengths = np.linalg.norm(normals, axis=1)
    low, high = corners.min(axis=1), corners.max(axis=1)
    found = np.full((len(points), 3), np.nan)
    for i, (point, direction) in enumerate(zip(points, directions, strict=True)):
        near = (low < point + reach).all(axis=1) & (high > point - reach).all(axis=1)
        near &= (normals @ direction >= 0.5 * lengths) & (lengths > 0)
        if near.any():
            candidates = _nearest_in_triangles(point, corners[near])
            distance = np.linalg.norm(candidates - point, axis=1)
            if distance.min() <= reach:
                found[i] = candidates[distance.argmin()]
    return found


def _intersect(
    points_2d: NDArray[np.floating], corners: NDArray[np.float64]
) -> tuple[NDArray[np.intp], NDArray[np.intp], NDArray[np.float64]]:
    """Return which positions (L, 2) are covered, the nearest triangle of (F, 3, 3) there, and its barycentric weights.

    Depth, the third coordinate, grows away from the viewer. Each position is tested against every triangle that
    overlaps the bounding box of all positions.
    """
    flat = corners[..., :2]
    low, high = (points_2d.min(axis=0), points_2d.max(axis=0)) if len(points_2d) else (np.zeros(2), np.zeros(2))
    near = np.flatnonzero((flat.max(axis=1) >= low).all(axis=1) & (flat.min(axis=1) <= high).all(axis=1))
    step = max(1, _CHUNK // max(1, len(near)))
    covered, hits = [np.empty(0, np.intp)], [np.empty(0, np.intp)]
    for start in range(0, len(points_2d), step):
        rows, hit = np.nonzero(_covers(points_2d[start : start + step], flat[near]))
        covered.append(rows + start)
        hits.append(near[hit])
    rows, hit = np.concatenate(covered), np.concatenate(hits)
    weights = _barycentric(points_2d[rows], flat[hit])
    order = np.lexsort(((weights * corners[hit][..., 2]).sum(axis=1), rows))
    rays, first = np.unique(rows[order], return_index=True)
    return rays, hit[order[first]], weights[order[first]]


def _nearest_in_triangles(point: NDArray[np.float64], corners: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the (F, 3) nearest point of each triangle (F, 3, 3): inside it, or on the nearest of its edges."""
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    projected = point - normal * ((point - a) * normal).sum(axis=1, keepdims=True)
    inside = np.ones(len(corners), dtype=bool)
    best, best_distance = projected.copy(), np.full(len(corners), np.inf)
    for start, end in ((a, b), (b, c), (c, a)):
        edge = end - start
        inside &= (np.cross(edge, projected - start) * normal).sum(axis=1) >= 0
        t = ((point - start) * edge).sum(axis=1) / np.maximum((edge * edge).sum(axis=1), 1e-300)
        on_edge = start + np.clip(t, 0.0, 1.0)[:, None] * edge
        distance = np.linalg.norm(on_edge - point, axis=1)
        best = np.where((distance < best_distance)[:, None], on_edge, best)
        best_distance = np.minimum(best_distance, distance)
    return np.asarray(np.where(inside[:, None], projected, best))


def _covers(points_2d: NDArray[np.floating], flat: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return (L, F): whether a triangle (F, 3, 2) covers a position (L, 2)."""
    low = np.full((len(points_2d), len(flat)), np.inf)
    high = -low
    for corner in range(3):
        a, b = flat[:, corner], flat[:, (corner + 1) % 3]
        x, y = (b - a).T
        side = x * (points_2d[:, 1, None] - a[:, 1]) - y * (points_2d[:, 0, None] - a[:, 0])
        np.minimum(low, side, out=low)
        np.maximum(high, side, out=high)
    return np.asarray(
        ((low >= -_EDGE_TOLERANCE) | (high <= _EDGE_TOLERANCE)) & (np.maximum(high, -low) > _EDGE_TOLERANCE)
    )


def _barycentric(points_2d: NDArray[np.floating], flat: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the (H, 3) barycentric weights of positions (H, 2) in triangles (H, 3, 2)."""
    a, b, c = (flat[:, corner] - points_2d for corner in range(3))
    areas = np.stack([p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0] for p, q in ((b, c), (c, a), (a, b))], axis=1)
    return np.asarray(areas / areas.sum(axis=1, keepdims=True))
