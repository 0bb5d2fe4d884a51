"""A triangle mesh over a photographed person: outlines of the face and a grid, dense at eyes and mouth.

The vertices are chosen first, each at a minimum distance from the others, then triangulated (Delaunay), so triangles
are no thinner than the vertices allow. The outlines are denser than the grid, so triangles do not cross the lips.
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
from conf.face.portrait.patch_features import EYES
from conf.face.portrait.photographed_face import PhotographedFace, project

SPACING_CM = {"feature": 0.5, "face": 0.9, "rest": 2.2}  # of the grid's points
MIN_SPACING = 0.55  # of the spacing: grid points nearer than this to another vertex are left out
LINE_MARGIN_CM = 0.15  # the grid has no points between lips or lids, nor within this distance of them
FACE_REACH = 1.25  # of the oval's radius: the extent of the face's spacing
OUTLINE_BORDER = 0.97  # of the distance from centre to border: outline points beyond it are cut off by the border
BORDER_EXTENSION = 0.6  # of the oval's width, that the person is extended beyond the border: a head moves by half of it
MAX_BORDER_EXTENSION = 0.4  # image heights
OUTLINE_MARGIN_CM = 0.8  # beyond the outline, over which the person's edge fades

_LIPS_AND_LIDS = contours.landmark_rows(contours.UPPER_OUTER_LIP + contours.LOWER_OUTER_LIP + EYES.centre_landmarks)


@dataclass(frozen=True)
class PhotoMesh:
    """Vertices over a whole photo, and the triangles that show some of the person.

    positions : (V, 2) float64
    triangles : (F, 3) int32, counter-clockwise
    neighbour_mean : (V, V) sparse, the mean over a vertex and its neighbours
    eyes : the openings between the lids; their triangles are the first
    """

    positions: NDArray[np.float64]
    triangles: NDArray[np.int32]
    neighbour_mean: sparse.csr_array
    eyes: tuple[EyeOpening, ...]


def build_mesh(face: PhotographedFace, /) -> PhotoMesh:
    """Return the mesh of a photographed face."""
    centimetre = float(np.exp(face.pose.log_scale))
    points = enforce_min_gap(project(face.points, face.pose), centimetre)
    positions = np.concatenate([points, _grid(points, centimetre, face)])
    triangles = _restore_constraint_edges(positions, _triangulate(positions, widen_openings(positions, points)))
    outline = extend_outline(face)
    triangles = triangles[triangles_on_person(positions, triangles, outline, OUTLINE_MARGIN_CM * centimetre)]
    positions, triangles, eyes = split_eye_openings(positions, triangles)
    neighbour_mean = _neighbour_mean(len(positions), triangles)
    return PhotoMesh(positions, triangles, neighbour_mean, eyes)


def signed_areas(positions: NDArray[np.float64], triangles: NDArray[np.int32], /) -> NDArray[np.float64]:
    """Return (F,) twice the area of each triangle, negative if it is folded over."""
    a, b, c = positions[triangles[:, 0]], positions[triangles[:, 1]], positions[triangles[:, 2]]
    first, second = b - a, c - a
    return np.asarray(first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0])


def border_extension(face: PhotographedFace, /) -> float:
    """Return how far the person is extended beyond the photo's border, image heights."""
    width = float(np.ptp(face.points[contours.OVAL_ROWS, 0])) * float(np.exp(face.pose.log_scale))
    return min(BORDER_EXTENSION * width, MAX_BORDER_EXTENSION)


def _grid(points: NDArray[np.float64], centimetre: float, face: PhotographedFace) -> NDArray[np.float64]:
    """Return the grid's points, those on the photo's border included, finest spacing first."""
    lips_and_lids, oval = cKDTree(points[_LIPS_AND_LIDS]), points[contours.OVAL_ROWS]
    centre = oval.mean(axis=0)
    radius = np.linalg.norm(oval - centre, axis=1).max()
    extension = border_extension(face)
    half = np.array([face.aspect / 2 + extension, 0.5 + extension])
    step = {name: spacing * centimetre for name, spacing in SPACING_CM.items()}
    kept = np.concatenate([points, _border(half, step["rest"]), _border(half - extension, step["rest"])])
    for name in SPACING_CM:
        candidates = _hexagons(half, max(step[name], 0.01))
        if name == "feature":
            candidates = candidates[lips_and_lids.query(candidates)[0] < 2 * step[name]]
        elif name == "face":
            candidates = candidates[np.linalg.norm(candidates - centre, axis=1) < FACE_REACH * radius]
        candidates = candidates[~inside_openings(candidates, points, LINE_MARGIN_CM * centimetre)]
        kept = np.concatenate([kept, candidates[cKDTree(kept).query(candidates)[0] > MIN_SPACING * step[name]]])
    return kept[len(points) :]


def _border(half: NDArray[np.float64], step: float) -> NDArray[np.float64]:
    """Return points on the border of a rectangle, corners included. half : (2,) of its width and height"""
    across, up = (np.linspace(-1, 1, max(2, round(2 * h / step) + 1)) for h in half)
    rows = [np.stack([across * half[0], np.full(len(across), s * half[1])], axis=1) for s in (-1, 1)]
    columns = [np.stack([np.full(len(up) - 2, s * half[0]), up[1:-1] * half[1]], axis=1) for s in (-1, 1)]
    return np.concatenate(rows + columns)


def _hexagons(half: NDArray[np.float64], step: float) -> NDArray[np.float64]:
    """Return the points of a hexagonal grid inside a rectangle."""
    ys = np.arange(-half[1] + step / 2, half[1] - step / 4, step * np.sqrt(3) / 2)
    xs = np.arange(-half[0] + step / 2, half[0] - step / 2, step)
    x, y = np.meshgrid(xs, ys)
    x = x + (np.arange(len(ys)) % 2 * step / 2)[:, None]
    grid = np.stack([x.ravel(), y.ravel()], axis=1).astype(np.float64)
    return np.asarray(grid[np.abs(grid[:, 0]) < half[0] - step / 4])


def _triangulate(positions: NDArray[np.float64], widened: NDArray[np.float64]) -> NDArray[np.int32]:
    """Return the Delaunay triangles of the widened openings, which do not cross the lips, if they have no folds."""
    triangles = _counter_clockwise(widened, Delaunay(widened).simplices.astype(np.int32))
    if signed_areas(positions, triangles).min() > 0:
        return triangles
    return _counter_clockwise(positions, Delaunay(positions).simplices.astype(np.int32))


def _restore_constraint_edges(positions: NDArray[np.float64], triangles: NDArray[np.int32]) -> NDArray[np.int32]:
    """Return triangles that have the edges of lips and lids: one across a lip would hold the mouth together.

    Two triangles whose common side crosses such an edge are replaced by the two that have the edge in common.
    """
    flipped = triangles.copy()
    for line in (line for pair in OPENINGS for line in pair):
        for a, b in pairwise(line):
            with_a, with_b = (np.flatnonzero((flipped == end).any(axis=1)) for end in (a, b))
            if np.intersect1d(with_a, with_b).size:
                continue
            for i, j in ((i, j) for i in with_a for j in with_b):
                common = np.intersect1d(flipped[i], flipped[j])
                replacement = np.array([[a, b, c] for c in common], np.int32)
                if len(common) == 2 and signed_areas(positions, replacement).prod() < 0:
                    flipped[[i, j]] = _counter_clockwise(positions, replacement)
                    break
    return flipped


def _counter_clockwise(positions: NDArray[np.float64], triangles: NDArray[np.int32]) -> NDArray[np.int32]:
    areas = signed_areas(positions, triangles)
    ordered = np.where((areas < 0)[:, None], triangles[:, ::-1], triangles)
    return np.ascontiguousarray(ordered[np.abs(areas) > 1e-12])


def _neighbour_mean(count: int, triangles: NDArray[np.int32]) -> sparse.csr_array:
    ends = np.concatenate([triangles[:, [a, b]] for a in range(3) for b in range(3)])
    linked = sparse.csr_array((np.ones(len(ends)), (ends[:, 0], ends[:, 1])), shape=(count, count))
    linked.data[:] = 1.0
    counts = np.maximum(linked.sum(axis=1), 1.0)
    return sparse.csr_array(sparse.diags_array(1 / counts) @ linked)


def extend_outline(face: PhotographedFace, /) -> NDArray[np.float64]:
    """Return the outline (K, 2) with the parts that touch the border moved beyond it."""
    half = np.array([face.aspect / 2, 0.5])
    at_border = np.abs(face.outline) > OUTLINE_BORDER * half
    return np.asarray(np.where(at_border, np.sign(face.outline) * (half + border_extension(face)), face.outline))


def triangles_on_person(
    positions: NDArray[np.float64], triangles: NDArray[np.int32], outline: NDArray[np.float64], margin: float
) -> NDArray[np.bool_]:
    """Return (F,) whether triangles show some of the person; those of the background need not move."""
    if len(outline) < 3:
        return np.ones(len(triangles), dtype=bool)
    corners = positions[triangles]
    centres = corners.mean(axis=1)
    radius = np.linalg.norm(corners - centres[:, None], axis=2).max(axis=1)
    return np.asarray(_inside(centres, outline) | (_distance(centres, outline) < radius + margin))


def _inside(points: NDArray[np.float64], outline: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return (k,) whether points are in a closed outline: a ray to the right crosses it an odd number of times."""
    a, b = outline, np.roll(outline, -1, axis=0)
    x, y = points[:, :1], points[:, 1:]
    crosses = (a[:, 1] > y) != (b[:, 1] > y)
    rise = np.where(a[:, 1] == b[:, 1], 1.0, b[:, 1] - a[:, 1])
    crossing_x = a[:, 0] + (y - a[:, 1]) / rise * (b[:, 0] - a[:, 0])
    return np.asarray(np.count_nonzero(crosses & (x < crossing_x), axis=1) % 2 == 1)


def _distance(points: NDArray[np.float64], outline: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return (k,) the distance of points to the nearest side of a closed outline."""
    sides = np.roll(outline, -1, axis=0) - outline
    offsets = points[:, None] - outline
    along = np.sum(offsets * sides, axis=2) / np.maximum(np.sum(sides * sides, axis=1), 1e-12)
    nearest = np.clip(along, 0, 1)[..., None] * sides
    return np.asarray(np.linalg.norm(offsets - nearest, axis=2).min(axis=1))
