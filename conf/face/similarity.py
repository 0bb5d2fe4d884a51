"""Similarity transforms: rotation, uniform scale and translation, and their weighted least-squares fit.

Source: Horn, Hilden, Negahdaripour 1988; Umeyama 1991.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class SimilarityTransform:
    """target = scale * rotation @ source + translation.

    rotation : (3, 3) float64, proper; scale : float; translation : (3,) float64
    """

    rotation: NDArray[np.float64]
    scale: float
    translation: NDArray[np.float64]

    def apply(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return transformed (..., 3) points."""
        return np.asarray(self.scale * points @ self.rotation.T + self.translation)

    def inverse_apply(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return (..., 3) points transformed back."""
        return np.asarray((points - self.translation) @ self.rotation / self.scale)

    def then(self, other: "SimilarityTransform") -> "SimilarityTransform":
        """Return the composition that applies this transform first and the other second."""
        rotation, scale = other.rotation @ self.rotation, other.scale * self.scale
        return SimilarityTransform(rotation, scale, other.apply(self.translation))


IDENTITY = SimilarityTransform(np.eye(3), 1.0, np.zeros(3))


def fit_similarity(
    source: NDArray[np.float64], target: NDArray[np.float64], weights: NDArray[np.float64] | None = None, /
) -> SimilarityTransform:
    """Return the similarity from source to target with the least weighted squared error.

    source, target : (K, 3), not collinear
    weights : (K,), not negative; None for equal weights
    """
    w = np.full(len(source), 1 / len(source)) if weights is None else weights / weights.sum()
    source_mean, target_mean = w @ source, w @ target
    a, b = source - source_mean, target - target_mean
    u, singular, vt = np.linalg.svd(b.T @ (w[:, None] * a))
    signs = np.array([1.0, 1.0, np.sign(np.linalg.det(u @ vt))])  # excludes reflections
    rotation = (u * signs) @ vt
    scale = float(singular @ signs / (w @ np.sum(a * a, axis=1)))
    return SimilarityTransform(rotation, scale, target_mean - scale * rotation @ source_mean)
