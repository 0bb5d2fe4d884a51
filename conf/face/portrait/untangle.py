"""Keep a deformed mesh from folding: move vertices as little as needed to give every triangle a positive area.

A folded triangle, or nearly folded one, pushes its corners apart along its heights until it has a minimum area. This is
iterated, because neighbours may have to give way. If folds remain, the non-rigid motion is smoothed around them, ever
wider; a deformation too large for that is reduced as a whole.
Source: Mueller et al. 2007 (position based dynamics), with areas as constraints.
"""

import numpy as np
from numpy.typing import NDArray

from conf.face.portrait.photo_mesh import PhotoMesh, signed_areas

MIN_AREA = 0.02  # of the triangle's area in the photo; below it counts as folded
TARGET_AREA = 0.05  # of the same: a folded triangle is corrected to it, so that few iterations are enough
AREA_ITERATIONS = 16  # in each smoothing round
SMOOTHING_ROUNDS = 4  # each wider than the one before
BISECTION_STEPS = 12


def untangle(target: NDArray[np.float64], mesh: PhotoMesh, /) -> NDArray[np.float64]:
    """Return positions (V, 2) near the target (V, 2) in which no triangle is folded."""
    positions = target
    for width in range(1, SMOOTHING_ROUNDS + 1):
        for _ in range(AREA_ITERATIONS):
            folded = _folded(positions, mesh)
            if not folded.any():
                return positions
            positions = positions + _area_correction(positions, mesh, folded)
        positions = _smooth_around_folds(positions, mesh, 2 * width)
    return _last_unfolded(_fit_similarity(target, mesh.positions), positions, mesh)


def _area_correction(positions: NDArray[np.float64], mesh: PhotoMesh, folded: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Return the offsets (V, 2) that give each folded triangle, taken alone, its target area."""
    triangles = mesh.triangles[folded]
    missing = TARGET_AREA * signed_areas(mesh.positions, triangles) - signed_areas(positions, triangles)
    corners = positions[triangles]
    sides = np.roll(corners, -2, axis=1) - np.roll(corners, -1, axis=1)  # opposite to each corner
    heights = np.stack([-sides[..., 1], sides[..., 0]], axis=2)  # gradient of the area
    steps = heights * (missing / np.maximum(np.sum(sides**2, axis=(1, 2)), 1e-12))[:, None, None]
    offsets, counts = np.zeros_like(positions), np.zeros((len(positions), 1))
    np.add.at(offsets, triangles, steps)
    np.add.at(counts, triangles, 1.0)
    return np.asarray(offsets / np.maximum(counts, 1))


def _smooth_around_folds(positions: NDArray[np.float64], mesh: PhotoMesh, width: int) -> NDArray[np.float64]:
    """Return positions (V, 2) with the non-rigid motion smoothed within `width` vertices of each fold."""
    rigid = _fit_similarity(positions, mesh.positions)
    residual = positions - rigid
    near = np.zeros(len(positions), dtype=bool)
    near[mesh.triangles[_folded(positions, mesh)]] = True
    for _ in range(width):
        near = mesh.neighbour_mean @ near > 0
    for _ in range(width):
        residual[near] = (mesh.neighbour_mean @ residual)[near]
    return np.asarray(rigid + residual)


def _folded(positions: NDArray[np.float64], mesh: PhotoMesh) -> NDArray[np.bool_]:
    return signed_areas(positions, mesh.triangles) < MIN_AREA * signed_areas(mesh.positions, mesh.triangles)


def _last_unfolded(start: NDArray[np.float64], end: NDArray[np.float64], mesh: PhotoMesh) -> NDArray[np.float64]:
    """Return the unfolded positions nearest to the end on the line from an unfolded start, by bisection."""
    if not _folded(end, mesh).any():
        return end
    good, bad = 0.0, 1.0
    for _ in range(BISECTION_STEPS):
        middle = (good + bad) / 2
        if _folded(start + middle * (end - start), mesh).any():
            bad = middle
        else:
            good = middle
    return np.asarray(start + good * (end - start))


def _fit_similarity(positions: NDArray[np.float64], photo: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the photo's vertices rotated, scaled (at least to 0.3) and shifted to fit positions (V, 2)."""
    a, b = photo - photo.mean(axis=0), positions - positions.mean(axis=0)
    complex_a, complex_b = a[:, 0] + 1j * a[:, 1], b[:, 0] + 1j * b[:, 1]
    factor = np.vdot(complex_a, complex_b) / max(np.vdot(complex_a, complex_a).real, 1e-12)
    scale = max(abs(factor), 0.3)
    rotated = complex_a * (factor / max(abs(factor), 1e-9)) * scale
    return np.asarray(np.column_stack([rotated.real, rotated.imag]) + positions.mean(axis=0))
