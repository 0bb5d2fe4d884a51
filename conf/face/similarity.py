"""The similarity that carries points nearest to points: a turn, a size and a shift.

Source: Horn, Hilden, Negahdaripour 1988; Umeyama 1991 (the least weighted squared error).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class SimilarityTransform:
    """target = scale * rotation @ source + shift.

    rotation : (3, 3) float64, proper; scale : float; shift : (3,) float64
    """

    rotation: NDArray[np.float64]
    scale: float
    translation: NDArray[np.float64]

    def apply(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Carry (..., 3) points."""
        return np.asarray(self.scale * points @ self.rotation.T + self.translation)

    def inverse_apply(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Carry (..., 3) points back."""
        return np.asarray((points - self.translation) @ self.rotation / self.scale)

    def then(self, other: "SimilarityTransform") -> "SimilarityTransform":
        """Return this one and the other after it as one."""
        return SimilarityTransform(
            other.rotation @ self.rotation, other.scale * self.scale, other.apply(self.translation)
        )


IDENTITY = SimilarityTransform(np.eye(3), 1.0, np.zeros(3))


def fit_similarity(
    source: NDArray[np.float64], target: NDArray[np.float64], weights: NDArray[np.float64] | None = None, /
) -> SimilarityTransform:
    """Find the similarity that carries points onto points with the least weighted squared error.

    source, target : (K, 3), not all on one line
    weights : (K,), not negative; None weighs all alike
    """
    share = np.full(len(source), 1 / len(source)) if weights is None else weights / weights.sum()
    source_middle, target_middle = share @ source, share @ target
    a, b = source - source_middle, target - target_middle
    u, stretch, vt = np.linalg.svd(b.T @ (share[:, None] * a))
    keep = np.array([1.0, 1.0, np.sign(np.linalg.det(u @ vt))])  # a mirror image is not a turn
    rotation = (u * keep) @ vt
    scale = float(stretch @ keep / (share @ np.sum(a * a, axis=1)))
    return SimilarityTransform(rotation, scale, target_middle - scale * rotation @ source_middle)
