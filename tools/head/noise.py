"""Smooth repeatable noise over space."""

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import map_coordinates

_LATTICE = np.random.default_rng(20070615).uniform(-1, 1, (48, 48, 48)).astype(np.float32)


def noise(points: NDArray[np.floating], frequency: float | tuple[float, float, float]) -> NDArray[np.float32]:
    """Return (N,) values of about -1 to 1 at (N, 3) points; frequency in lattice cells per unit of length."""
    where = (np.asarray(points, dtype=np.float32) * np.asarray(frequency, dtype=np.float32)).T + 24.0
    fraction = where - np.floor(where)
    smooth = np.floor(where) + fraction * fraction * (3 - 2 * fraction)
    return map_coordinates(_LATTICE, smooth % 48, order=1, mode="grid-wrap")


def layered(points: NDArray[np.floating], frequency: float, octaves: int) -> NDArray[np.float32]:
    """Return the sum of octaves of noise, each twice as fine and half as strong."""
    return np.sum([noise(points, frequency * 2**i) / 2**i for i in range(octaves)], axis=0) / 1.5


def smoothstep(low: float, high: float, x: NDArray[np.floating]) -> NDArray[np.floating]:
    """Return 0 below low, 1 above high (or the reverse when low > high), smooth between."""
    t = np.clip((x - low) / (high - low), 0, 1)
    return t * t * (3 - 2 * t)
