"""Which patches are shown, and how strongly: those whose keys are nearest to what the face does now."""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

DISTANCE_POWER = 2.0  # the power of distance: high shows one patch alone nearly always
MAX_VISIBLE = 2  # patches at once


def blend_weights(now: NDArray[np.floating], keys: Sequence[NDArray[np.floating]], /) -> NDArray[np.float64]:
    """Return how much of each candidate is shown, (len(keys),), together 1, at most SHOWN of them above 0.

    The shares change without a jump while `now` moves: a candidate enters and leaves the few that are shown at 0.
    """
    distance = np.array([float(np.linalg.norm(now - key)) for key in keys]) + 1.0
    closeness = distance**-DISTANCE_POWER
    if len(keys) > MAX_VISIBLE:
        closeness = np.maximum(0.0, closeness - np.sort(closeness)[-MAX_VISIBLE - 1])
    total = float(closeness.sum())
    return closeness / total if total > 1e-12 else np.eye(len(keys))[int(np.argmin(distance))]


def compositing_order(shares: Mapping[int, float], /) -> list[tuple[int, float]]:
    """Return (candidate, opacity) from the bottom up, so that painting one over the other gives the shares.

    Candidate -1 is what already lies there.
    """
    covered = 1.0
    painted: list[tuple[int, float]] = []
    for candidate, share in sorted(shares.items(), key=lambda item: item[1]):
        if candidate >= 0 and share > 0:
            painted.append((candidate, share / covered))
            covered -= share
            if covered <= 1e-9:
                break
    return painted[::-1]
