"""How open each eye is, from a tracker whose lid landmarks never quite meet.

A drawn eye must shut when the person's does. On the clips the lid landmarks of a shut eye keep 0 to 0.28 of their open
gap, by person and glasses; the blendshapes say when an eye is shut, so the share that is left is learned by watching.
"""

import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_INDEX
from conf.sender.tracking.blendshape_network import INDEX as SHAPE

SHUT_SHARE = 0.16  # of the open gap, before any blink has been seen; the mean over the clips
MAX_SHUT_SHARE = 0.3
SHUT_BLENDSHAPE = 0.65  # a blink shape this strong is a shut eye
LEARNING_RATE = 0.1  # a frame
MAX_OPENNESS = 2.0

# (2,) each: left, right
UPPER = np.array([CONTROL_POINT_INDEX["eyelid_upper_l"], CONTROL_POINT_INDEX["eyelid_upper_r"]])
LOWER = np.array([CONTROL_POINT_INDEX["eyelid_lower_l"], CONTROL_POINT_INDEX["eyelid_lower_r"]])
_BLINKS = np.array([SHAPE["eyeBlinkLeft"], SHAPE["eyeBlinkRight"]])


class EyeOpennessEstimator:
    """Learns what a shut eye looks like on one person, and measures how open the eyes are."""

    def __init__(self) -> None:
        self.closed_gap_ratio = np.full(2, SHUT_SHARE)  # left, right: of the neutral gap, what is left when shut

    def update(
        self, points: NDArray[np.float64], neutral: NDArray[np.float64], blendshapes: NDArray[np.floating], /
    ) -> None:
        """Learn from a frame.

        points, neutral : (n, 3) cm in face axes, control points now and in the neutral pose
        blendshapes : (52,) 0 to 1, of the same frame
        """
        left_over = np.clip(lid_gaps(points) / lid_gaps(neutral), 0, MAX_SHUT_SHARE)
        shut = blendshapes[_BLINKS] >= SHUT_BLENDSHAPE
        self.closed_gap_ratio = self.closed_gap_ratio + LEARNING_RATE * shut * (left_over - self.closed_gap_ratio)

    def openness(self, points: NDArray[np.float64], neutral: NDArray[np.float64], /) -> NDArray[np.float64]:
        """Return (2,), left and right: 0 shut, 1 as open as in the neutral pose, more when wide."""
        share = lid_gaps(points) / lid_gaps(neutral)
        return np.asarray(np.clip((share - self.closed_gap_ratio) / (1 - self.closed_gap_ratio), 0, MAX_OPENNESS))


def lid_gaps(points: NDArray[np.float64], /) -> NDArray[np.float64]:
    """Return (2,) how far the lids of the left and right eye are apart, in the unit of the points (n, 3)."""
    return np.asarray(points[UPPER, 1] - points[LOWER, 1])
