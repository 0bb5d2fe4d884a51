"""The mesh over a photographed person: the face's outlines are vertices, and the rest is a grid, dense at eyes and mouth.

Strategy: points first, each no nearer to its neighbours than the place asks for; then Delaunay's triangles, which are
never thinner than the points make them. The outlines are dense beside the grid, so triangles do not cross the lips.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import Delaunay, cKDTree

from conf.face.portrait import contours
from conf.face.portrait.shape import FaceShape, project

LEAST_GAP_CM = 0.03  # between facing lips or lids in the photograph: shut ones have no room for triangles
SPACING_CM = {"feature": 0.5, "face": 0.9, "rest": 2.2}  # between the grid's points
BESIDE = 0.55  # of the spacing: nearer than this to another vertex a grid point is left out
OUTLINE_MARGIN_CM = 0.8  # beyond the person's outline, over which his edge fades
FACE_REACH = 1.25  # of the oval's radius: where the face's spacing ends

_FACING = [
    (contours.rows(upper[1:-1]), contours.rows(lower[1:-1]))
    for upper, lower in (
        (contours.UPPER_INNER_LIP, contours.LOWER_INNER_LIP),
        (contours.UPPER_LID_R, contours.LOWER_LID_R),
        (contours.UPPER_LID_L, contours.LOWER_LID_L),
    )
]
_FEATURES = contours.rows(
    contours.UPPER_OUTER_LIP
    + contours.LOWER_OUTER_LIP
    + contours.UPPER_LID_R
    + contours.LOWER_LID_R
    + contours.UPPER_LID_L
    + contours.LOWER_LID_L
)
_OVAL = contours.rows(contours.OVAL)


@dataclass(frozen=True)
class PhotoMesh:
    """Vertices over a whole picture, and the triangles that show some of the person.

    places : (V, 2) float64 picture heights, x right, y up; the first D are the shape's points
    triangles : (F, 3) int32, counter-clockwise
    in_mouth : (F,) bool, the triangles between the lips
    """

    places: NDArray[np.float64]
    triangles: NDArray[np.int32]
    in_mouth: NDArray[np.bool_]


def part_lips_and_lids(places: NDArray[np.float64], centimetre: float, /) -> NDArray[np.float64]:
    """Return the shape's points (D, 2) with facing lips and lids at least LEAST_GAP_CM apart.

    centimetre : its length in the picture
    """
    parted = places.copy()
    for upper, lower in _FACING:
        lack = np.maximum(0.0, LEAST_GAP_CM * centimetre - (parted[upper, 1] - parted[lower, 1])) / 2
        parted[upper, 1] += lack
        parted[lower, 1] -= lack
    return parted


def build_mesh(shape: FaceShape, /) -> PhotoMesh:
    """Lay a mesh over the photograph of a face."""
    centimetre = float(np.exp(shape.pose.log_scale))
    points = part_lips_and_lids(project(shape.points, shape.pose), centimetre)
    places = np.concatenate([points, _grid(points, centimetre, shape.aspect)])
    triangles = _counter_clockwise(places, Delaunay(places).simplices.astype(np.int32))
    triangles = triangles[_show_person(places, triangles, shape.outline, OUTLINE_MARGIN_CM * centimetre)]
    ring = np.zeros(len(places), dtype=bool)
    ring[contours.rows(contours.UPPER_INNER_LIP + contours.LOWER_INNER_LIP)] = True
    return PhotoMesh(places, triangles, _in_mouth(places, triangles, ring))


def signed_areas(places: NDArray[np.float64], triangles: NDArray[np.int32], /) -> NDArray[np.float64]:
    """Return (F,) twice the area of each triangle, negative where it is turned over."""
    a, b, c = places[triangles[:, 0]], places[triangles[:, 1]], places[triangles[:, 2]]
    first, second = b - a, c - a
    return np.asarray(first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0])


def _grid(points: NDArray[np.float64], centimetre: float, aspect: float) -> NDArray[np.float64]:
    """Return the grid's points, the picture's border included: finest first, each at its distance to the others."""
    features, oval = cKDTree(points[_FEATURES]), points[_OVAL]
    middle = oval.mean(axis=0)
    radius = np.linalg.norm(oval - middle, axis=1).max()
    half = np.array([aspect / 2, 0.5])
    step = {name: spacing * centimetre for name, spacing in SPACING_CM.items()}
    kept = np.concatenate([points, _border(half, step["rest"])])
    for name, reach in (("feature", 2 * step["feature"]), ("face", FACE_REACH * radius), ("rest", np.inf)):
        candidates = _hexagons(half, max(step[name], 0.01))
        if name == "feature":
            candidates = candidates[features.query(candidates)[0] < reach]
        elif name == "face":
            candidates = candidates[np.linalg.norm(candidates - middle, axis=1) < reach]
        kept = np.concatenate([kept, candidates[cKDTree(kept).query(candidates)[0] > BESIDE * step[name]]])
    return kept[len(points) :]


def _border(half: NDArray[np.float64], step: float) -> NDArray[np.float64]:
    """Return points on the picture's border, corners included."""
    across, up = (np.linspace(-1, 1, max(2, round(2 * h / step) + 1)) for h in half)
    rows = [np.stack([across * half[0], np.full(len(across), s * half[1])], axis=1) for s in (-1, 1)]
    columns = [np.stack([np.full(len(up) - 2, s * half[0]), up[1:-1] * half[1]], axis=1) for s in (-1, 1)]
    return np.concatenate(rows + columns)


def _hexagons(half: NDArray[np.float64], step: float) -> NDArray[np.float64]:
    """Return the points of a hexagonal grid inside the picture."""
    ys = np.arange(-half[1] + step / 2, half[1] - step / 4, step * np.sqrt(3) / 2)
    xs = np.arange(-half[0] + step / 2, half[0] - step / 2, step)
    x, y = np.meshgrid(xs, ys)
    x = x + (np.arange(len(ys)) % 2 * step / 2)[:, None]
    grid = np.stack([x.ravel(), y.ravel()], axis=1).astype(np.float64)
    return np.asarray(grid[np.abs(grid[:, 0]) < half[0] - step / 4])


def _counter_clockwise(places: NDArray[np.float64], triangles: NDArray[np.int32]) -> NDArray[np.int32]:
    areas = signed_areas(places, triangles)
    turned = np.where((areas < 0)[:, None], triangles[:, ::-1], triangles)
    return np.ascontiguousarray(turned[np.abs(areas) > 1e-12])


def _show_person(
    places: NDArray[np.float64], triangles: NDArray[np.int32], outline: NDArray[np.float64], margin: float
) -> NDArray[np.bool_]:
    """Tell the triangles that show some of the person: what is only background need not move, and cannot fold."""
    corners = places[triangles]
    if len(outline) < 3:
        return np.ones(len(triangles), dtype=bool)
    middles = corners.mean(axis=1)
    reach = np.linalg.norm(corners - middles[:, None], axis=2).max(axis=1)
    return np.asarray(_inside(middles, outline) | (_distance(middles, outline) < reach + margin))


def _inside(points: NDArray[np.float64], outline: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Tell the points (k, 2) inside a closed outline: those whose ray to the right crosses it an odd number of times."""
    a, b = outline, np.roll(outline, -1, axis=0)
    x, y = points[:, :1], points[:, 1:]
    crosses = (a[:, 1] > y) != (b[:, 1] > y)
    rise = np.where(a[:, 1] == b[:, 1], 1.0, b[:, 1] - a[:, 1])
    at = a[:, 0] + (y - a[:, 1]) / rise * (b[:, 0] - a[:, 0])
    return np.asarray(np.count_nonzero(crosses & (x < at), axis=1) % 2 == 1)


def _distance(points: NDArray[np.float64], outline: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return (k,) how far points are from the nearest side of a closed outline."""
    sides = np.roll(outline, -1, axis=0) - outline
    away = points[:, None] - outline
    along = np.sum(away * sides, axis=2) / np.maximum(np.sum(sides * sides, axis=1), 1e-12)
    nearest = np.clip(along, 0, 1)[..., None] * sides
    return np.asarray(np.linalg.norm(away - nearest, axis=2).min(axis=1))


def _in_mouth(places: NDArray[np.float64], triangles: NDArray[np.int32], ring: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Tell the triangles whose corners all lie on the inner lips and whose middle lies between them."""
    upper, lower = (places[contours.rows(c)] for c in (contours.UPPER_INNER_LIP, contours.LOWER_INNER_LIP))
    middle = places[triangles].mean(axis=1)
    right_to_left = np.argsort(upper[:, 0]), np.argsort(lower[:, 0])
    top = np.interp(middle[:, 0], upper[right_to_left[0], 0], upper[right_to_left[0], 1])
    bottom = np.interp(middle[:, 0], lower[right_to_left[1], 0], lower[right_to_left[1], 1])
    inside = (middle[:, 1] < top) & (middle[:, 1] > bottom)
    return np.asarray(ring[triangles].all(axis=1) & inside)
