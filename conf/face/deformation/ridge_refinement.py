"""Operator B, refined on sculpted shapes.

An artist's 52 shapes of the shipped head say how skin really follows its control points. B is the matrix that best
carries the control points' displacements D of the shapes to their vertex offsets X, without straying from the RBF
matrix where the shapes say nothing: min |(B D - X) W|^2 + lambda |B - B_rbf|^2, ridge regression with a prior. The
weights W make small shapes heard beside an open jaw.
"""

import numpy as np
from numpy.typing import NDArray

from conf.face.deformation.blendshapes import Blendshapes
from conf.face.deformation.regions import Regions
from conf.face.deformation.rig import CHIN, Jaw, jaw_offsets

# lambda, cm: of those that rebuild a held-out jaw to 1 mm, the least error on all, see tools/bench/deformation.py
SMOOTHING = 0.1
_MIN_SIZE = 0.3  # cm, root of the summed squares at the control points: smaller shapes weigh no more
_JAW_SHAPES = ("jawForward", "jawLeft", "jawRight")  # what follows the jaw moves as far as the chin, the rest does not


def refine_with_blendshapes(
    matrix: NDArray[np.float32],
    displacements: NDArray[np.float32],
    offsets: NDArray[np.float32],
    /,
    *,
    regions: Regions,
    smoothing: float = SMOOTHING,
) -> NDArray[np.float32]:
    """Return the matrix that fits the shapes, with the given one as prior.

    matrix : (V, n) the RBF operator
    displacements : (S, n, 3) of the control points in each shape, model units
    offsets : (S, V, 3) of the vertices in each shape, model units
    regions : those of the operator: what a field leaves out is not learned in it either
    smoothing : lambda, model units: how much of the prior is kept
    Returns (V, n) float32.
    """
    n = matrix.shape[1]
    weights = blendshape_importance(displacements)[:, None, None]
    D = (displacements * weights).transpose(1, 0, 2).reshape(n, -1)
    X = (offsets * weights).transpose(1, 0, 2).reshape(len(matrix), -1)
    left = X - matrix @ D
    refined = matrix.copy()
    for field in regions.fields:
        known = np.setdiff1d(np.arange(n), field.excluded)
        wide = D[known].astype(np.float64)
        correction = np.linalg.solve(wide @ wide.T + smoothing * np.eye(len(known)), wide).astype(np.float32)
        rows = np.flatnonzero(field.weights)
        refined[np.ix_(rows, known)] += field.weights[rows, None].astype(np.float32) * (left[rows] @ correction.T)
    return refined


def blendshape_importance(displacements: NDArray[np.float32], /) -> NDArray[np.float32]:
    """Return the (S,) weight of each shape: one over the root of its size, (S, n, 3) model units."""
    sizes = np.linalg.norm(displacements.reshape(len(displacements), -1), axis=1)
    return np.asarray(1 / np.sqrt(np.maximum(sizes, _MIN_SIZE)), np.float32)


def subtract_jaw_motion(
    jaw: Jaw, points: NDArray[np.float64], displacements: NDArray[np.float32], offsets: NDArray[np.float32], /
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Take the jaw's turn out of shapes: what the operator is left to carry.

    points : (n, 3) control points at rest, model units
    displacements : (S, n, 3), offsets : (S, V, 3) of control points and vertices in each shape
    Returns displacements and offsets of the same shapes.
    """
    displacements, offsets = displacements.copy(), offsets.copy()
    for moved, carried in zip(displacements, offsets, strict=True):
        motion = jaw.estimate_motion(points, moved)
        moved -= jaw_offsets(jaw.weighted_point_offsets, jaw.point_weights, motion)
        carried[jaw.vertices] -= jaw_offsets(jaw.weighted_offsets, jaw.weights, motion)
    return displacements, offsets


def jaw_weights(shapes: Blendshapes, nearest: NDArray[np.integer], /) -> NDArray[np.float64]:
    """Return the (V,) shares by which vertices follow the jaw, from the shapes that shift it: 0 not at all, 1 wholly.

    nearest : (n,) the vertex of each control point
    """
    used = [i for i, name in enumerate(shapes.names) if name in _JAW_SHAPES]
    chin = shapes.offsets[used][:, nearest[CHIN]].mean(axis=1).astype(np.float64)
    along = np.einsum("svi,si->v", shapes.offsets[used], chin)
    return np.asarray(np.clip(along / max(float((chin**2).sum()), 1e-9), 0.0, 1.0))
