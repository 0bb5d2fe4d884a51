"""Interpolation curves."""

import numpy as np
from numpy.typing import ArrayLike, NDArray


def smoothstep(t: ArrayLike, /) -> NDArray[np.float64]:
    """Return 3t^2 - 2t^3 with t clamped to 0..1: it rises from 0 to 1 with slope 0 at both ends."""
    clamped = np.clip(t, 0.0, 1.0)
    return np.asarray(clamped * clamped * (3.0 - 2.0 * clamped))
