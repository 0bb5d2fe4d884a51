"""Keep a moved mesh from turning triangles over: where a motion would fold it, it goes only as far as it can."""

import numpy as np
from numpy.typing import NDArray

from conf.face.portrait.mesh import PhotoMesh, signed_areas

LEAST_SHARE = 0.02  # of its own area that a triangle keeps
ROUNDS = 10  # of holding back single vertices, before the whole motion is held back


def unfold(target: NDArray[np.float64], still: NDArray[np.float64], mesh: PhotoMesh, /) -> NDArray[np.float64]:
    """Return places (V, 2) near the target in which every triangle keeps its sense.

    target : (V, 2) where the vertices should go
    still : (V, 2) where they would go without the expression
    """
    if not _folded(target, mesh).any():
        return target
    if _folded(still, mesh).any():
        still = _as_far_as_it_goes(_similar(still, mesh.places), still, mesh)
    return _as_far_as_it_goes(still, target, mesh)


def _as_far_as_it_goes(start: NDArray[np.float64], end: NDArray[np.float64], mesh: PhotoMesh) -> NDArray[np.float64]:
    """Return places near the end that are not folded, held back towards a start that is not: single vertices first."""
    held = np.ones((len(end), 1))
    for number in range(ROUNDS):
        places = start + held * (end - start)
        folded = _folded(places, mesh)
        if not folded.any():
            return np.asarray(places)
        held[np.unique(mesh.triangles[folded])] *= 0.6
        for _ in range(1 + number // 2):  # ever wider around, so that what is held back does not stand out
            held = np.minimum(held, mesh.around @ held)
    return _on_the_way(start, start + held * (end - start), mesh)


def _folded(places: NDArray[np.float64], mesh: PhotoMesh) -> NDArray[np.bool_]:
    return signed_areas(places, mesh.triangles) < _least(mesh)


def _least(mesh: PhotoMesh) -> NDArray[np.float64]:
    return LEAST_SHARE * signed_areas(mesh.places, mesh.triangles)


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
