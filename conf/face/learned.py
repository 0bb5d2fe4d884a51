"""Operator B, refined on sculpted shapes.

An artist's 52 shapes of the shipped head say how skin really follows its control points. B is the matrix that
carries the control points' displacements D of the shapes to their vertex offsets X best, without straying from the
RBF matrix where the shapes say nothing: min |B D - X|^2 + lambda |B - B_rbf|^2, ridge regression with a prior.
"""

import numpy as np
from numpy.typing import NDArray


def refine_operator(
    matrix: NDArray[np.float32],
    displacements: NDArray[np.floating],
    offsets: NDArray[np.floating],
    /,
    *,
    smoothing: float,
) -> NDArray[np.float32]:
    """Return the matrix that fits the shapes, with the given one as prior.

    matrix : (V, n) the RBF operator
    displacements : (S, n, 3) of the control points in each shape, model units
    offsets : (S, V, 3) of the vertices in each shape, model units
    smoothing : lambda, model units squared: how much of the prior is kept
    Returns (V, n) float32.
    """
    n = matrix.shape[1]
    D = np.asarray(displacements, dtype=np.float32).transpose(1, 0, 2).reshape(n, -1)
    X = np.ascontiguousarray(offsets, dtype=np.float32).transpose(1, 0, 2).reshape(len(matrix), -1)
    gram = D.astype(np.float64) @ D.T.astype(np.float64) + smoothing * np.eye(n)
    correction = np.linalg.solve(gram, D.astype(np.float64)).astype(np.float32)
    return np.asarray(matrix + (X - matrix @ D) @ correction.T, dtype=np.float32)
