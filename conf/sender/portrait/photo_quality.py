"""How good a portrait a frame would make: of the face as it mostly is, at rest, sharp, eyes open, uncovered.

What is far from the photograph is drawn worse than what is near. So a photograph should show what the face does most of
the time, be that a shut mouth or a half-open one, and the head as it is mostly held. Of all that was measured on
clips, the mean distance of the control points from where they usually are told best which photograph serves a call.
"""

from collections import deque
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_COUNT, CONTROL_POINT_INDEX
from conf.face.fapu import UNITS_PER_DISTANCE
from conf.protocol.messages import MotionFrame
from conf.sender.portrait.skin_texture import skin_texture_residual

TURN = np.radians(10)  # a turn or tilt from the usual this large costs a whole mark
EXPRESSION_UNIT = 120.0  # FAPU units of mean distance from the usual that cost a whole mark
LID_UNIT = 0.4  # of the eye's opening, either way, that costs a whole mark
SPEED_TURN_UNIT, HASTY_STIR = 1.3, 1800.0  # radians and FAPU units a second, each of which costs a whole mark
COVERED = 0.12  # of roughness (conf.sender.portrait.skin_texture) that costs a whole mark
SHARPNESS_WEIGHT = 0.2  # marks for each factor of e in sharpness
LOOK_EVERY_S = 0.2
SAMPLES = 100  # twenty seconds
NEUTRAL_LOOKS = 3  # that stand in until more is known


class TypicalPose:
    """What a face mostly does, and where it mostly looks: the median of some time."""

    def __init__(self) -> None:
        neutral = np.zeros(2 * CONTROL_POINT_COUNT + 3)
        self._looks: deque[NDArray[np.float64]] = deque([neutral] * NEUTRAL_LOOKS, maxlen=SAMPLES)
        self._usual = neutral
        self._due = float("-inf")

    @property
    def displacements(self) -> NDArray[np.float64]:
        """The usual ones, (n, 2) FAPU units, across and up."""
        return self._usual[3:].reshape(-1, 2)

    @property
    def rotation(self) -> NDArray[np.float64]:
        """The usual one, (3,), as a pose has it."""
        return self._usual[:3]

    def sample(self, motion: MotionFrame, now: float, /) -> None:
        """Take a look at a frame's motion, if it is time for one."""
        if now < self._due:
            return
        self._due = now + LOOK_EVERY_S
        self._looks.append(np.concatenate([motion.pose[:3], motion.displacements[:, :2].ravel()]))
        self._usual = np.asarray(np.median(self._looks, axis=0), np.float64)


@dataclass(frozen=True)
class QualityPenalty:
    """What speaks against a frame, each 0 when perfect and 1 when bad."""

    turn: float
    expression: float
    lids: float

    @property
    def penalty(self) -> float:
        """Return the sum: lower is better."""
        return self.turn + self.expression + self.lids


def motion_penalty(motion: MotionFrame, habit: TypicalPose, /) -> QualityPenalty:
    """Judge a frame by its motion."""
    d = motion.displacements
    lids = [
        float(d[CONTROL_POINT_INDEX[f"eyelid_upper_{s}"], 1] - d[CONTROL_POINT_INDEX[f"eyelid_lower_{s}"], 1])
        for s in "lr"
    ]
    return QualityPenalty(
        turn=float(np.linalg.norm(motion.pose[:3] - habit.rotation)) / TURN,
        expression=float(np.linalg.norm(d[:, :2] - habit.displacements, axis=1).mean()) / EXPRESSION_UNIT,
        lids=max(abs(lid) for lid in lids) / UNITS_PER_DISTANCE / LID_UNIT,
    )


def speed_penalty(before: MotionFrame, motion: MotionFrame, /) -> float:
    """Return the marks of how fast a face moves between two frames: it is blurred then, and the motion lags behind."""
    elapsed = motion.timestamp - before.timestamp
    if elapsed <= 0:
        return 0.0
    turn = float(np.linalg.norm(motion.pose[:3] - before.pose[:3]))
    stir = float(np.linalg.norm((motion.displacements - before.displacements)[:, :2], axis=1).mean())
    return (turn / SPEED_TURN_UNIT + stir / HASTY_STIR) / elapsed


def image_penalty(pixels: NDArray[np.uint8], landmarks: NDArray[np.floating], /) -> float:
    """Return the marks of a frame's pixels, lower is better; compare frames of one person and camera only.

    pixels : (H, W, 3) uint8 BGR; landmarks : (478, 3) px
    """
    return skin_texture_residual(pixels, landmarks) / COVERED - SHARPNESS_WEIGHT * float(
        np.log1p(sharpness(pixels, landmarks))
    )


def sharpness(pixels: NDArray[np.uint8], landmarks: NDArray[np.floating], /) -> float:
    """Return how sharp the face is: the mean square of its Laplacian; compare frames of one camera only.

    pixels : (H, W, 3) uint8 BGR; landmarks : (478, 3) px
    """
    height, width = pixels.shape[:2]
    low = np.clip(landmarks[:, :2].min(axis=0), 0, (width - 2, height - 2)).astype(int)
    high = np.clip(landmarks[:, :2].max(axis=0), low + 2, (width, height)).astype(int)
    face = cv2.cvtColor(pixels[low[1] : high[1], low[0] : high[0]], cv2.COLOR_BGR2GRAY)
    return float(np.mean(np.square(cv2.Laplacian(face, cv2.CV_32F))))
