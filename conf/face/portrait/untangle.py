"""Keep a moved mesh from turning triangles over: corners are moved as little as that takes.

Strategy: a triangle that is turned over, or nearly, pushes its corners apart along its own heights until it has a least
area, and again, since its neighbours may have to give way. Where that does not end, what vertices move besides the
whole is evened out among neighbours, ever wider around; a motion too wild for all this is held back everywhere.
Source: Mueller et al. 2007 (position based dynamics), with areas for constraints.
"""

import numpy as np
from numpy.typing import NDArray

from conf.face.portrait.photo_mesh import PhotoMesh, signed_areas

LEAST_SHARE = 0.02  # of its own area that a triangle keeps
AIM = 0.05  # of its own area that a triangle is brought back to, so that few rounds do
AREA_ITERATIONS = 16  # rounds of pushing corners apart, before motion is evened out around what is still folded
SMOOTHING_ROUNDS = 4  # of that, each wider and smoother than the one before; then motion is held back everywhere


def untangle(target: NDArray[np.float64], mesh: PhotoMesh, /) -> NDArray[np.float64]:
    """Return places (V, 2) near the target in which every triangle keeps its sense.

    target : (V, 2) where the vertices should go
    """
    places = target
    for width in range(1, SMOOTHING_ROUNDS + 1):
        for _ in range(AREA_ITERATIONS):
            folded = _folded(places, mesh)
            if not folded.any():
                return places
            places = places + _area_correction(places, mesh, folded)
        places = _smooth_around_folds(places, mesh, 2 * width)
    return _on_the_way(_similar(target, mesh.positions), places, mesh)


def _area_correction(places: NDArray[np.float64], mesh: PhotoMesh, folded: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Return how far to move vertices (V, 2) so that the folded triangles get their least area, each by itself."""
    triangles = mesh.triangles[folded]
    lack = AIM * signed_areas(mesh.positions, triangles) - signed_areas(places, triangles)
    corners = places[triangles]
    sides = np.roll(corners, -2, axis=1) - np.roll(corners, -1, axis=1)  # the side that faces each corner
    heights = np.stack([-sides[..., 1], sides[..., 0]], axis=2)  # the way that adds most area
    steps = heights * (lack / np.maximum(np.sum(sides**2, axis=(1, 2)), 1e-12))[:, None, None]
    moves, counts = np.zeros_like(places), np.zeros((len(places), 1))
    np.add.at(moves, triangles, steps)
    np.add.at(counts, triangles, 1.0)
    return np.asarray(moves / np.maximum(counts, 1))


def _smooth_around_folds(places: NDArray[np.float64], mesh: PhotoMesh, width: int) -> NDArray[np.float64]:
    """Return places (V, 2) whose motion is smooth for `width` vertices around each fold."""
    whole = _similar(places, mesh.positions)
    beside = places - whole
    rough = np.zeros(len(places), dtype=bool)
    rough[mesh.triangles[_folded(places, mesh)]] = True
    for _ in range(width):
        rough = mesh.neighbour_mean @ rough > 0
    for _ in range(width):
        beside[rough] = (mesh.neighbour_mean @ beside)[rough]
    return np.asarray(whole + beside)


def _folded(places: NDArray[np.float64], mesh: PhotoMesh) -> NDArray[np.bool_]:
    return signed_areas(places, mesh.triangles) < LEAST_SHARE * signed_areas(mesh.positions, mesh.triangles)


def _on_the_way(
    start: NDArray[np.float64], end: NDArray[np.float64], mesh: PhotoMesh, steps: int = 12
) -> NDArray[np.float64]:
    """Return the place nearest to the end, on the straight way from a start that is not folded, that is not either."""
    if not _folded(end, mesh).any():
        return end
    good, bad = 0.0, 1.0
    for _ in range(steps):
        middle = (good + bad) / 2
        if _folded(start + middle * (end - start), mesh).any():
            bad = middle
        else:
            good = middle
    return np.asarray(start + good * (end - start))


def _similar(places: NDArray[np.float64], photo: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the photograph's vertices turned, sized and shifted as a whole: never folded."""
    a, b = photo - photo.mean(axis=0), places - places.mean(axis=0)
    complex_a, complex_b = a[:, 0] + 1j * a[:, 1], b[:, 0] + 1j * b[:, 1]
    factor = np.vdot(complex_a, complex_b) / max(np.vdot(complex_a, complex_a).real, 1e-12)
    size = max(abs(factor), 0.3)
    turned = complex_a * (factor / max(abs(factor), 1e-9)) * size
    return np.asarray(np.column_stack([turned.real, turned.imag]) + places.mean(axis=0))
