"""The mesh over a photographed person: the face's outlines are vertices, the rest a grid, dense at eyes and mouth.

Strategy: points first, each no nearer to its neighbours than the place asks for; then Delaunay's triangles, which are
never thinner than the points make them. The outlines are dense beside the grid, so triangles do not cross the lips.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.spatial import Delaunay, cKDTree

from conf.face.portrait import contours
from conf.face.portrait.eyelid_closure import EyeOpening, split_eye_openings
from conf.face.portrait.lip_lid_gaps import OPENINGS, enforce_min_gap, inside_openings, widen_openings
from conf.face.portrait.person_outline import BORDER_EXTENSION, OUTLINE_MARGIN_CM, extend_outline, triangles_on_person
from conf.face.portrait.photographed_face import PhotographedFace, project

SPACING_CM = {"feature": 0.5, "face": 0.9, "rest": 2.2}  # between the grid's points
MIN_SPACING = 0.55  # of the spacing: nearer than this to another vertex a grid point is left out
LINE_MARGIN_CM = 0.15  # from inner lips and lids: between them and this near the grid has no vertices
FACE_REACH = 1.25  # of the oval's radius: where the face's spacing ends

_FEATURES = contours.landmark_rows(
    contours.UPPER_OUTER_LIP
    + contours.LOWER_OUTER_LIP
    + contours.UPPER_LID_R
    + contours.LOWER_LID_R
    + contours.UPPER_LID_L
    + contours.LOWER_LID_L
)
_OVAL = contours.landmark_rows(contours.OVAL)


@dataclass(frozen=True)
class PhotoMesh:
    """Vertices over a whole picture, and the triangles that show some of the person.

    places : (V, 2) float64 picture heights, x right, y up; the first D are the shape's points
    triangles : (F, 3) int32, counter-clockwise
    in_mouth : (F,) bool, the triangles between the lips
    around : (V, V) sparse, the mean over a vertex and its neighbours
    eyeballs : what lies between the lids; its triangles are the first
    """

    positions: NDArray[np.float64]
    triangles: NDArray[np.int32]
    in_mouth: NDArray[np.bool_]
    neighbour_mean: sparse.csr_array
    eyeballs: tuple[EyeOpening, ...]


def build_mesh(shape: PhotographedFace, /) -> PhotoMesh:
    """Lay a mesh over the photograph of a face."""
    centimetre = float(np.exp(shape.pose.log_scale))
    points = enforce_min_gap(project(shape.points, shape.pose), centimetre)
    places = np.concatenate([points, _grid(points, centimetre, shape.aspect)])
    triangles = _restore_constraint_edges(places, _triangulate(places, widen_openings(places, points, centimetre)))
    outline = extend_outline(shape.outline, shape.aspect)
    triangles = triangles[triangles_on_person(places, triangles, outline, OUTLINE_MARGIN_CM * centimetre)]
    places, triangles, eyeballs = split_eye_openings(places, triangles)
    ring = np.zeros(len(places), dtype=bool)
    ring[contours.landmark_rows(contours.UPPER_INNER_LIP + contours.LOWER_INNER_LIP)] = True
    return PhotoMesh(places, triangles, _in_mouth(places, triangles, ring), _around(len(places), triangles), eyeballs)


def signed_areas(positions: NDArray[np.float64], triangles: NDArray[np.int32], /) -> NDArray[np.float64]:
    """Return (F,) twice the area of each triangle, negative where it is turned over."""
    a, b, c = positions[triangles[:, 0]], positions[triangles[:, 1]], positions[triangles[:, 2]]
    first, second = b - a, c - a
    return np.asarray(first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0])


def _grid(points: NDArray[np.float64], centimetre: float, aspect: float) -> NDArray[np.float64]:
    """Return the grid's points, the picture's border included: finest first, each at its distance to the others."""
    features, oval = cKDTree(points[_FEATURES]), points[_OVAL]
    middle = oval.mean(axis=0)
    radius = np.linalg.norm(oval - middle, axis=1).max()
    half = np.array([aspect / 2 + BORDER_EXTENSION, 0.5 + BORDER_EXTENSION])
    step = {name: spacing * centimetre for name, spacing in SPACING_CM.items()}
    kept = np.concatenate([points, _border(half, step["rest"]), _border(half - BORDER_EXTENSION, step["rest"])])
    for name, reach in (("feature", 2 * step["feature"]), ("face", FACE_REACH * radius), ("rest", np.inf)):
        candidates = _hexagons(half, max(step[name], 0.01))
        if name == "feature":
            candidates = candidates[features.query(candidates)[0] < reach]
        elif name == "face":
            candidates = candidates[np.linalg.norm(candidates - middle, axis=1) < reach]
        candidates = candidates[~inside_openings(candidates, points, LINE_MARGIN_CM * centimetre)]
        kept = np.concatenate([kept, candidates[cKDTree(kept).query(candidates)[0] > MIN_SPACING * step[name]]])
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


def _triangulate(positions: NDArray[np.float64], opened: NDArray[np.float64]) -> NDArray[np.int32]:
    """Return triangles over places (V, 2) that do not cross the lips: Delaunay's over the opened mouth, if they fit."""
    triangles = _counter_clockwise(opened, Delaunay(opened).simplices.astype(np.int32))
    if signed_areas(positions, triangles).min() > 0:
        return triangles
    return _counter_clockwise(positions, Delaunay(positions).simplices.astype(np.int32))


def _restore_constraint_edges(positions: NDArray[np.float64], triangles: NDArray[np.int32]) -> NDArray[np.int32]:
    """Return triangles whose sides include those of lips and lids: one across a lip would hold the mouth together.

    Two triangles whose common side crosses a line are exchanged for the two that share the line's.
    """
    kept = triangles.copy()
    for line in (line for pair in OPENINGS for line in pair):
        for a, b in pairwise(line):
            with_a, with_b = (np.flatnonzero((kept == end).any(axis=1)) for end in (a, b))
            if np.intersect1d(with_a, with_b).size:
                continue
            for i, j in ((i, j) for i in with_a for j in with_b):
                common = np.intersect1d(kept[i], kept[j])
                exchanged = np.array([[a, b, c] for c in common], np.int32)
                if len(common) == 2 and signed_areas(positions, exchanged).prod() < 0:
                    kept[[i, j]] = _counter_clockwise(positions, exchanged)
                    break
    return kept


def _counter_clockwise(positions: NDArray[np.float64], triangles: NDArray[np.int32]) -> NDArray[np.int32]:
    areas = signed_areas(positions, triangles)
    turned = np.where((areas < 0)[:, None], triangles[:, ::-1], triangles)
    return np.ascontiguousarray(turned[np.abs(areas) > 1e-12])


def _around(count: int, triangles: NDArray[np.int32]) -> sparse.csr_array:
    ends = np.concatenate([triangles[:, [a, b]] for a in range(3) for b in range(3)])
    ones = np.ones(len(ends))
    linked = sparse.csr_array((ones, (ends[:, 0], ends[:, 1])), shape=(count, count))
    linked.data[:] = 1.0
    counts = np.maximum(linked.sum(axis=1), 1.0)
    return sparse.csr_array(sparse.diags_array(1 / counts) @ linked)


def _in_mouth(
    positions: NDArray[np.float64], triangles: NDArray[np.int32], ring: NDArray[np.bool_]
) -> NDArray[np.bool_]:
    """Tell the triangles whose corners all lie on the inner lips and whose middle lies between them."""
    upper, lower = (positions[contours.landmark_rows(c)] for c in (contours.UPPER_INNER_LIP, contours.LOWER_INNER_LIP))
    middle = positions[triangles].mean(axis=1)
    right_to_left = np.argsort(upper[:, 0]), np.argsort(lower[:, 0])
    top = np.interp(middle[:, 0], upper[right_to_left[0], 0], upper[right_to_left[0], 1])
    bottom = np.interp(middle[:, 0], lower[right_to_left[1], 0], lower[right_to_left[1], 1])
    inside = (middle[:, 1] < top) & (middle[:, 1] > bottom)
    return np.asarray(ring[triangles].all(axis=1) & inside)
