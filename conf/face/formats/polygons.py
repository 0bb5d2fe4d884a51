"""Triangulate concave polygons, whose fans of triangles would lie outside them and overlap."""

import numpy as np
from numpy.typing import NDArray

_MAX_CORNERS = 64  # of a polygon; a larger one keeps its fan
_MAX_WORK = 100_000  # sum of the squares of the corners of all polygons that are clipped: about a second

_Point = tuple[float, float]


def split_concave(positions: NDArray[np.float64], corners: NDArray[np.int64], polygons: NDArray[np.int64], /) -> None:
    """Replace the fans of concave polygons by triangles inside them, in place; the winding stays.

    positions : (V, 3); corners : (F, 3, 2), position index and texture coordinate index of each corner
    polygons : (P, 2), the first triangle and the number of triangles of each fan of more than one triangle
    """
    work = 0
    for count in np.unique(polygons[:, 1]):
        firsts = polygons[polygons[:, 1] == count, 0]
        rows = firsts[:, None] + np.arange(count)
        outline = np.concatenate([corners[firsts, :1], corners[rows, 1], corners[rows[:, -1:], 2]], axis=1)
        for number in np.flatnonzero(_is_concave(positions, outline[..., 0])):
            work += int(count + 2) ** 2
            if count + 2 > _MAX_CORNERS or work > _MAX_WORK:
                return
            triangles = clip_ears(_flattened(positions[outline[number, :, 0]]))
            corners[rows[number]] = outline[number][np.array(triangles)]


def _is_concave(positions: NDArray[np.float64], outlines: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Return (P,) whether some triangle of the fan faces away from the polygon. outlines : (P, n) vertices"""
    exists = np.asarray(((outlines >= 0) & (outlines < len(positions))).all(axis=1), np.bool_)
    points = positions[np.where(exists[:, None], outlines, 0)]
    usable = np.asarray(exists & (np.abs(points) < 1e9).all(axis=(1, 2)), np.bool_)
    points = np.where(usable[:, None, None], points, 0.0)
    edges = points[:, 1:] - points[:, :1]
    normals = np.cross(edges[:, :-1], edges[:, 1:])
    sides = np.einsum("pfi,pi->pf", normals, normals.sum(axis=1))
    return np.asarray(sides.min(axis=1) < -1e-9 * np.abs(sides).max(axis=1))


def _flattened(points: NDArray[np.float64]) -> list[_Point]:
    """Return the points (n, 3) of a polygon in its plane, counterclockwise. Source of the normal: Newell's method."""
    after = np.roll(points, -1, axis=0)
    normal = np.cross(points, after).sum(axis=0)
    axis = int(np.argmax(np.abs(normal)))
    flat = np.delete(points, axis, axis=1)
    is_clockwise = (normal[axis] < 0) ^ (axis == 1)
    return [(-float(x), float(y)) if is_clockwise else (float(x), float(y)) for x, y in flat]


def clip_ears(points: list[_Point], /) -> list[tuple[int, int, int]]:
    """Return the triangles of a polygon without holes, as indices of its points, which run counterclockwise.

    Source: Meisters, "Polygons have ears", 1975.
    """
    left, triangles = list(range(len(points))), []
    while len(left) > 3:
        for k in range(len(left)):
            a, b, c = left[k - 1], left[k], left[(k + 1) % len(left)]
            if _cross(points[a], points[b], points[c]) > 0 and not any(
                _is_inside(points[other], points[a], points[b], points[c]) for other in left if other not in (a, b, c)
            ):
                triangles.append((a, b, c))
                del left[k]
                break
        else:  # it crosses itself
            return triangles + [(left[0], left[i], left[i + 1]) for i in range(1, len(left) - 1)]
    return [*triangles, (left[0], left[1], left[2])]


def _cross(a: _Point, b: _Point, c: _Point) -> float:
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def _is_inside(point: _Point, a: _Point, b: _Point, c: _Point) -> bool:
    if point in (a, b, c):
        return False
    return _cross(a, b, point) >= 0 and _cross(b, c, point) >= 0 and _cross(c, a, point) >= 0
