"""Blend weights of patches and views: those whose descriptors are nearest to the face's current one are shown."""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

DISTANCE_POWER = 2.0  # of inverse distance weighting; a higher power nearly always shows a single patch
MAX_VISIBLE = 2  # candidates at once


def blend_weights(
    descriptor: NDArray[np.floating], candidates: Sequence[NDArray[np.floating]], /, *, power: float = DISTANCE_POWER
) -> NDArray[np.float64]:
    """Return the weight of each candidate's descriptor (k,): sum 1, at most MAX_VISIBLE of them above 0.

    The weights are continuous in the descriptor (k,): a candidate enters and leaves the visible ones with weight 0.
    """
    return weights_of_distances(np.linalg.norm(np.array(candidates) - descriptor, axis=1), power=power)


def weights_of_distances(distances: NDArray[np.float64], /, *, power: float = DISTANCE_POWER) -> NDArray[np.float64]:
    """Return the weights (..., M), as blend_weights does, of candidates at distances (..., M)."""
    closeness = (distances + 1.0) ** -power
    if distances.shape[-1] > MAX_VISIBLE:
        closeness = np.maximum(0.0, closeness - np.sort(closeness, axis=-1)[..., -MAX_VISIBLE - 1, None])
    total = closeness.sum(axis=-1, keepdims=True)
    nearest = np.eye(distances.shape[-1])[np.argmin(distances, axis=-1)]
    return np.asarray(np.where(total > 1e-12, closeness / np.maximum(total, 1e-12), nearest))


def compositing_order(weights: Mapping[int, float], /) -> list[tuple[int, float]]:
    """Return (candidate, opacity) from bottom to top, such that drawing them in this order yields the weights.

    Candidate -1 is what has been drawn before.
    """
    remaining = 1.0
    layers: list[tuple[int, float]] = []
    for candidate, weight in sorted(weights.items(), key=lambda item: item[1]):
        if candidate >= 0 and weight > 0:
            layers.append((candidate, weight / remaining))
            remaining -= weight
            if remaining <= 1e-9:
                break
    return layers[::-1]
