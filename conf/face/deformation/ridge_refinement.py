"""Refine operator B on blendshapes.

The default head's 52 blendshapes, made by an artist, show how skin follows its control points. B is fitted to map the
control points' displacements D in the blendshapes to their vertex offsets X, and stays at the RBF matrix where the
blendshapes do not determine it: min |(B D - X) W|^2 + lambda |B - B_rbf|^2, ridge regression with a prior. The weights
W keep small blendshapes from being outweighed by an open jaw.
"""

import numpy as np
from numpy.typing import NDArray

from conf.face.deformation.blendshapes import Blendshapes
from conf.face.deformation.regions import Regions
from conf.face.deformation.rig import CHIN, Jaw, jaw_offsets

# lambda, cm: the least error on all blendshapes among the values that reproduce a held-out jaw to 1 mm,
# see tools/bench/deformation.py
SMOOTHING = 0.1
_MIN_SIZE = 0.3  # cm, norm of the displacements: smaller blendshapes get no larger weight
_JAW_SHAPES = ("jawForward", "jawLeft", "jawRight")  # translations: vertices that follow the jaw move as the chin does


def refine_with_blendshapes(
    matrix: NDArray[np.float32],
    displacements: NDArray[np.float32],
    offsets: NDArray[np.float32],
    /,
    *,
    regions: Regions,
    smoothing: float = SMOOTHING,
) -> NDArray[np.float32]:
    """Return the (V, n) float32 matrix that fits the blendshapes, with the given one as prior.

    matrix : (V, n) the RBF operator
    displacements : (S, n, 3) of the control points in each blendshape, model units
    offsets : (S, V, 3) of the vertices in each blendshape, model units
    regions : of the operator; points excluded from a field stay excluded
    smoothing : lambda, model units: how strongly the prior is kept
    """
    n = matrix.shape[1]
    weights = blendshape_importance(displacements)[:, None, None]
    D = (displacements * weights).transpose(1, 0, 2).reshape(n, -1)
    X = (offsets * weights).transpose(1, 0, 2).reshape(len(matrix), -1)
    residuals = X - matrix @ D
    refined = matrix.copy()
    for field in regions.fields:
        used = np.setdiff1d(np.arange(n), field.excluded)
        A = D[used].astype(np.float64)
        correction = np.linalg.solve(A @ A.T + smoothing * np.eye(len(used)), A).astype(np.float32)
        rows = np.flatnonzero(field.weights)
        refined[np.ix_(rows, used)] += field.weights[rows, None].astype(np.float32) * (residuals[rows] @ correction.T)
    return refined


def blendshape_importance(displacements: NDArray[np.float32], /) -> NDArray[np.float32]:
    """Return the (S,) weight of each blendshape (S, n, 3), model units: one over the square root of its norm."""
    sizes = np.linalg.norm(displacements.reshape(len(displacements), -1), axis=1)
    return np.asarray(1 / np.sqrt(np.maximum(sizes, _MIN_SIZE)), np.float32)


def subtract_jaw_motion(
    jaw: Jaw, points: NDArray[np.float64], displacements: NDArray[np.float32], offsets: NDArray[np.float32], /
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Return displacements and offsets of blendshapes without the motion of the jaw.

    points : (n, 3) neutral control points, model units
    displacements : (S, n, 3), offsets : (S, V, 3) of control points and vertices in each blendshape
    """
    displacements, offsets = displacements.copy(), offsets.copy()
    for of_points, of_vertices in zip(displacements, offsets, strict=True):
        motion = jaw.estimate_motion(points, of_points)
        of_points -= jaw_offsets(jaw.weighted_point_offsets, jaw.point_weights, motion)
        of_vertices[jaw.vertices] -= jaw_offsets(jaw.weighted_offsets, jaw.weights, motion)
    return displacements, offsets


def jaw_weights(shapes: Blendshapes, nearest: NDArray[np.integer], /) -> NDArray[np.float64]:
    """Return the (V,) weights, 0 to 1, by which vertices follow the jaw, from the blendshapes that translate it.

    nearest : (n,) vertex nearest to each control point
    """
    used = [i for i, name in enumerate(shapes.names) if name in _JAW_SHAPES]
    chin = shapes.offsets[used][:, nearest[CHIN]].mean(axis=1).astype(np.float64)
    along = np.einsum("svi,si->v", shapes.offsets[used], chin)
    return np.asarray(np.clip(along / max(float((chin**2).sum()), 1e-9), 0.0, 1.0))
