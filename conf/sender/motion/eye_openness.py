"""Estimate how open each eye is, from a tracker whose lid landmarks never quite meet.

A drawn eye must be shut when the person's is. On the clips the lid landmarks of a shut eye keep 0 to 0.28 of their
neutral gap, depending on person and glasses. The blendshapes show when an eye is shut, so this ratio is learned.
"""

import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import control_point_indices
from conf.sender.tracking.blendshape_network import INDEX as SHAPE

CLOSED_GAP_RATIO = 0.16  # of the neutral gap, assumed until a blink; the mean over the clips
MAX_CLOSED_GAP_RATIO = 0.3
MIN_BLINK = 0.65  # blink blendshape from which an eye whose gap may be that of a shut one is shut
CERTAIN_BLINK = 0.8  # from which it is shut whatever its gap: one that looks down has up to 0.77
LEARNING_RATE = 0.1  # per frame
MAX_OPENNESS = 2.0

# Left, right.
UPPER, LOWER = control_point_indices("eyelid_upper"), control_point_indices("eyelid_lower")
_BLINKS = [SHAPE["eyeBlinkLeft"], SHAPE["eyeBlinkRight"]]


class EyeOpennessEstimator:
    """Learns the lid gap of one person's shut eyes.

    closed_gap_ratio : (2,), left and right: gap of the shut eye over the neutral gap
    """

    def __init__(self) -> None:
        self.closed_gap_ratio = np.full(2, CLOSED_GAP_RATIO)

    def update(
        self, points: NDArray[np.float64], neutral: NDArray[np.float64], blendshapes: NDArray[np.floating], /
    ) -> None:
        """Learn from a frame.

        points, neutral : (n, 3) cm in face axes, control points now and in the neutral pose
        blendshapes : (52,) 0 to 1, of the same frame
        """
        measured, blink = lid_gaps(points) / lid_gaps(neutral), blendshapes[_BLINKS]
        ratio = np.clip(measured, 0, MAX_CLOSED_GAP_RATIO)
        shut = (blink >= np.where(measured <= MAX_CLOSED_GAP_RATIO, MIN_BLINK, CERTAIN_BLINK)).astype(np.float64)
        self.closed_gap_ratio = self.closed_gap_ratio + LEARNING_RATE * shut * (ratio - self.closed_gap_ratio)

    def openness(self, points: NDArray[np.float64], neutral: NDArray[np.float64], /) -> NDArray[np.float64]:
        """Return (2,), left and right: 0 shut, 1 as in the neutral pose, at most MAX_OPENNESS."""
        ratio = lid_gaps(points) / lid_gaps(neutral)
        return np.asarray(np.clip((ratio - self.closed_gap_ratio) / (1 - self.closed_gap_ratio), 0, MAX_OPENNESS))


def lid_gaps(points: NDArray[np.float64], /) -> NDArray[np.float64]:
    """Return the lid gaps (2,) of the left and right eye, in the unit of the points (n, 3)."""
    return np.asarray(points[UPPER, 1] - points[LOWER, 1])
