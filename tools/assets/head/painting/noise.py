"""Smooth deterministic noise in space."""

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import map_coordinates

_LATTICE = np.random.default_rng(20070615).uniform(-1, 1, (48, 48, 48)).astype(np.float32)


Floats = NDArray[np.float64]


def noise(points: NDArray[np.floating], frequency: float | tuple[float, float, float]) -> Floats:
    """Return (N,) values of about -1 to 1 at (N, 3) points; frequency in lattice cells per unit of length."""
    position = (np.asarray(points, dtype=float) * np.asarray(frequency, dtype=float)).T + 24.0
    fraction = position - np.floor(position)
    smooth = np.floor(position) + fraction * fraction * (3 - 2 * fraction)
    return np.asarray(map_coordinates(_LATTICE, smooth % 48, order=1, mode="grid-wrap"), dtype=float)


def layered(points: NDArray[np.floating], frequency: float, octaves: int) -> Floats:
    """Return the sum of octaves of noise, each with twice the frequency and half the amplitude."""
    return np.asarray(np.sum([noise(points, frequency * 2**i) / 2**i for i in range(octaves)], axis=0) / 1.5)


def smoothstep(low: float | Floats, high: float | Floats, x: NDArray[np.floating]) -> Floats:
    """Return 0 below low, 1 above high (or the reverse when low > high), smooth between."""
    t = np.clip((x - low) / (high - low), 0, 1)
    return np.asarray(t * t * (3 - 2 * t), dtype=float)
