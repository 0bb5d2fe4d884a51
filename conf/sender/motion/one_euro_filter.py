"""The One Euro filter: a low-pass filter whose cutoff rises with the speed.

Source: Casiez, Roussel, Vogel 2012, 1 Euro Filter: A Simple Speed-based Low-pass Filter for Noisy Input.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

DERIVATIVE_CUTOFF = 1.0  # Hz, as in the paper
MAX_GAP = 0.5  # seconds without a value after which the filter starts again


class OneEuroFilter:
    """Smooths an array of values, each by its own speed."""

    def __init__(self, *, min_cutoff: ArrayLike, beta: ArrayLike) -> None:
        """Make a filter.

        min_cutoff : Hz, of values at rest; a number or an array that broadcasts to the values
        beta : Hz per unit of value per second; likewise
        Raises ValueError if a cutoff is not positive or a beta is negative.
        """
        self._min_cutoff = np.asarray(min_cutoff, dtype=np.float64)
        self._beta = np.asarray(beta, dtype=np.float64)
        if np.any(self._min_cutoff <= 0) or np.any(self._beta < 0):
            raise ValueError("min_cutoff must be positive and beta must not be negative")
        self._value: NDArray[np.float64] | None = None
        self._speed: NDArray[np.float64] = np.zeros(())
        self._time = float("-inf")

    def reset(self) -> None:
        """Start again: the next value is returned unchanged."""
        self._value = None

    def smooth(self, values: NDArray[np.floating], timestamp: float, /) -> NDArray[np.float64]:
        """Return the smoothed values at a time in seconds."""
        new = np.asarray(values, dtype=np.float64)
        elapsed = timestamp - self._time
        self._time = timestamp
        if self._value is None or not 0 < elapsed <= MAX_GAP:
            self._value, self._speed = new, np.zeros_like(new)
            return new
        speed = (new - self._value) / elapsed
        self._speed = self._speed + _smoothing_factor(DERIVATIVE_CUTOFF, elapsed) * (speed - self._speed)
        cutoff = self._min_cutoff + self._beta * np.abs(self._speed)
        self._value = self._value + _smoothing_factor(cutoff, elapsed) * (new - self._value)
        return self._value


def _smoothing_factor(cutoff: ArrayLike, elapsed: float) -> NDArray[np.float64]:
    """Return the weight, 0 to 1, of a new value in a first-order low-pass filter."""
    radians = 2 * np.pi * np.asarray(cutoff, dtype=np.float64) * elapsed
    return np.asarray(radians / (radians + 1))
