"""Blend weights of patches: those whose descriptors are nearest to the face's current one are shown."""

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
    distance = np.array([float(np.linalg.norm(descriptor - candidate)) for candidate in candidates]) + 1.0
    closeness = distance**-power
    if len(candidates) > MAX_VISIBLE:
        closeness = np.maximum(0.0, closeness - np.sort(closeness)[-MAX_VISIBLE - 1])
    total = float(closeness.sum())
    return closeness / total if total > 1e-12 else np.eye(len(candidates))[int(np.argmin(distance))]


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
