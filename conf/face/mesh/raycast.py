"""Find places on the surface of a mesh: what is seen at a place of a picture, and what is nearest."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

_CHUNK = 1 << 21  # tests of a place against a triangle at a time
_RIM = 1e-12  # a place on an edge belongs to both triangles


@dataclass(frozen=True)
class RayHits:
    """What rays from the viewer, along -z, meet first.

    points : (L, 3), nan where there is nothing
    triangles : (L,) the triangle met, -1 where there is none
    """

    points: NDArray[np.float64]
    triangles: NDArray[np.intp]


def cast_clip_rays(
    points_2d: NDArray[np.floating],
    clip: NDArray[np.float64],
    vertices: NDArray[np.float64],
    triangles: NDArray[np.int32],
) -> NDArray[np.float64]:
    """Return the (L, 3) point of the mesh that is seen at each place of a picture, nan where there is none.

    places : (L, 2) in the picture, -1 to 1, x right, y up
    clip : (4, 4) from a homogeneous column of the vertices' coordinates to clip coordinates
    vertices : (V, 3); triangles : (F, 3); both sides of a triangle are seen
    """
    seen = vertices @ clip[:, :3].T + clip[:, 3]
    before = triangles[(seen[:, 3] > 0)[triangles].all(axis=1)]
    corners = seen[before]
    place, hit, shares = _intersect(points_2d, corners[..., :3] / np.where(corners[..., 3:] > 0, corners[..., 3:], 1.0))
    shares = shares / corners[hit][..., 3]  # straight in the picture is not straight in depth
    points = np.full((len(points_2d), 3), np.nan)
    points[place] = np.einsum("hc,hci->hi", shares, vertices[before[hit]]) / shares.sum(axis=1, keepdims=True)
    return points


def cast_front_rays(
    points_2d: NDArray[np.float64], vertices: NDArray[np.float64], triangles: NDArray[np.int32]
) -> RayHits:
    """Return what rays along -z through each place (L, 2), x and y, meet of a mesh (V, 3), (F, 3)."""
    points, found = np.full((len(points_2d), 3), np.nan), np.full(len(points_2d), -1, dtype=np.intp)
    place, hit, shares = _intersect(points_2d, vertices[triangles] * [1.0, 1.0, -1.0])
    points[place] = np.einsum("hc,hci->hi", shares, vertices[triangles[hit]])
    found[place] = hit
    return RayHits(points, found)


def _intersect(
    points_2d: NDArray[np.floating], corners: NDArray[np.float64]
) -> tuple[NDArray[np.intp], NDArray[np.intp], NDArray[np.float64]]:
    """Return which places (L, 2) are covered, the nearest triangle of (F, 3, 3) at each, and the shares of its corners.

    Depth, the third coordinate, grows away from the viewer. All triangles lie flat in the picture, and each place is
    tested against every one of them that may cover any.
    """
    flat = corners[..., :2]
    low, high = (points_2d.min(axis=0), points_2d.max(axis=0)) if len(points_2d) else (np.zeros(2), np.zeros(2))
    near = np.flatnonzero((flat.max(axis=1) >= low).all(axis=1) & (flat.min(axis=1) <= high).all(axis=1))
    step = max(1, _CHUNK // max(1, len(near)))
    covered, hits = [], []
    for start in range(0, len(points_2d), step):
        place, hit = np.nonzero(_covering(points_2d[start : start + step], flat[near]))
        covered.append(place + start)
        hits.append(near[hit])
    place, hit = np.concatenate([np.empty(0, np.intp), *covered]), np.concatenate([np.empty(0, np.intp), *hits])
    shares = _barycentric(points_2d[place], flat[hit])
    order = np.lexsort(((shares * corners[hit][..., 2]).sum(axis=1), place))
    seen, first = np.unique(place[order], return_index=True)
    return seen, hit[order[first]], shares[order[first]]


def nearest_points(
    points_2d: NDArray[np.float64],
    directions: NDArray[np.float64],
    vertices: NDArray[np.float64],
    triangles: NDArray[np.int32],
    *,
    reach: float,
) -> NDArray[np.float64]:
    """Return the nearest point of the surface to each place that faces the way it should, nan if none is in reach.

    places : (n, 3); facing : (n, 3) unit directions the surface there should look, within 60 degrees
    """
    corners = vertices[triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(normals, axis=1)
    low, high = corners.min(axis=1), corners.max(axis=1)
    found = np.full((len(points_2d), 3), np.nan)
    for i, (place, way) in enumerate(zip(points_2d, directions, strict=True)):
        near = (low < place + reach).all(axis=1) & (high > place - reach).all(axis=1)
        near &= (normals @ way >= 0.5 * lengths) & (lengths > 0)
        if near.any():
            points = _nearest_in_triangles(place, corners[near])
            distance = np.linalg.norm(points - place, axis=1)
            if distance.min() <= reach:
                found[i] = points[distance.argmin()]
    return found


def nearest_normals(
    points_2d: NDArray[np.float64], vertices: NDArray[np.float64], triangles: NDArray[np.int32]
) -> NDArray[np.float64]:
    """Return the (n, 3) unit normal of the surface at the vertex nearest to each place (n, 3)."""
    corners = vertices[triangles]
    faces = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    used = np.unique(triangles)
    nearest = used[[np.linalg.norm(vertices[used] - place, axis=1).argmin() for place in points_2d]]
    normals = np.array([faces[(triangles == vertex).any(axis=1)].sum(axis=0) for vertex in nearest])
    return np.asarray(normals / np.linalg.norm(normals, axis=1, keepdims=True))


def _nearest_in_triangles(place: NDArray[np.float64], corners: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the (F, 3) nearest point of each triangle (F, 3, 3): inside it, or on the nearest of its edges."""
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    inside = place - normal * ((place - a) * normal).sum(axis=1, keepdims=True)
    within = np.ones(len(corners), dtype=bool)
    best, distance = inside.copy(), np.full(len(corners), np.inf)
    for start, end in ((a, b), (b, c), (c, a)):
        edge = end - start
        within &= (np.cross(edge, inside - start) * normal).sum(axis=1) >= 0
        along = ((place - start) * edge).sum(axis=1) / np.maximum((edge * edge).sum(axis=1), 1e-300)
        on_edge = start + np.clip(along, 0.0, 1.0)[:, None] * edge
        away = np.linalg.norm(on_edge - place, axis=1)
        best = np.where((away < distance)[:, None], on_edge, best)
        distance = np.minimum(distance, away)
    return np.asarray(np.where(within[:, None], inside, best))


def _covering(points_2d: NDArray[np.floating], flat: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return (L, F): does a triangle (F, 3, 2) of the picture cover a place (L, 2)?"""
    low = np.full((len(points_2d), len(flat)), np.inf)
    high = -low
    for corner in range(3):
        a, b = flat[:, corner], flat[:, (corner + 1) % 3]
        x, y = (b - a).T
        side = x * (points_2d[:, 1, None] - a[:, 1]) - y * (points_2d[:, 0, None] - a[:, 0])
        np.minimum(low, side, out=low)
        np.maximum(high, side, out=high)
    return np.asarray(((low >= -_RIM) | (high <= _RIM)) & (high - low > _RIM))


def _barycentric(points_2d: NDArray[np.floating], flat: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the (H, 3) shares of the corners (H, 3, 2) at places (H, 2) inside them."""
    a, b, c = (flat[:, corner] - points_2d for corner in range(3))
    areas = [p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0] for p, q in ((b, c), (c, a), (a, b))]
    shares = np.stack(areas, axis=1)
    return np.asarray(shares / shares.sum(axis=1, keepdims=True))
