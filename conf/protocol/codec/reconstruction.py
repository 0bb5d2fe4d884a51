"""Estimate where inside its step a value was rounded, from the frames before it: precision that costs no bits.

Strategy. Rounding loses the position of a value inside its step, but the motion of a face is smooth and its values move
together. A value that was one step away in the previous frame has most likely just crossed the border. The lips that
have begun to open go on opening, also in the values that did not yet reach their next step. Both are linear in clipped
differences, fitted by least squares to the error of the codec's own output. What is estimated is only shown: later
frames are predicted from the integers. Shrinking a value towards zero would lessen the squared error too, but also the
expressions, so it is not done.
Source: Martin, Cohen 1986 (the border); regression on the decoder's side as in adaptive loop filters, ITU-T H.266.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

HISTORY = 2  # earlier frames used


@dataclass(frozen=True)
class Reconstruction:
    """The fitted coefficients. V = 6 + K values in a frame, steps.

    previous : (V,) of the distance to the same value of the previous frame, if that is at most a step
    history : (HISTORY, V, V) of the clipped distances to each value (rows) of the frame one and two strides earlier
    """

    previous: NDArray[np.float64]
    history: NDArray[np.float64]

    def expected_error(
        self, values: NDArray[np.float64], earlier: Sequence[NDArray[np.float64]], /
    ) -> NDArray[np.float64]:
        """Return what to add to the values (V,) of a frame. earlier : those one and two strides earlier, if known"""
        error = np.zeros(len(values))
        for age, (before, coefficients) in enumerate(zip(earlier, self.history, strict=False)):
            distance = before - values
            if age == 0:
                error += self.previous * near(distance)
            error += clipped(distance) @ coefficients
        return error


def clipped(distance: NDArray[np.float64], /) -> NDArray[np.float64]:
    """Return distances limited to a step. numpy.clip takes four times as long for so few."""
    return np.minimum(np.maximum(distance, -1.0), 1.0)


def near(distance: NDArray[np.float64], /) -> NDArray[np.float64]:
    """Return distances of at most a step, and 0 for larger ones: the value has not just crossed a border."""
    return np.where(np.abs(distance) <= 1, distance, 0.0)
