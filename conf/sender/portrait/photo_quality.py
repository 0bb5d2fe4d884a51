"""Score a frame as a portrait photo: the typical pose and expression, at rest, sharp, eyes open, nothing in front.

Strategy: the receiver draws a face worse the farther it is from the photo. So a photo should show the typical
expression and head rotation of the call, be that a shut or a half-open mouth. Of all measures tried on clips, the mean
distance of the control points from their typical positions predicted best which photo serves a call. All penalties add
up; lower is better. A `..._UNIT` is the deviation that adds 1.
"""

from collections import deque

import cv2
import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_COUNT
from conf.face.fapu import UNITS_PER_DISTANCE
from conf.protocol.messages import MotionFrame
from conf.sender.motion.eye_openness import LOWER, UPPER
from conf.sender.portrait.occlusion import skin_texture_residual

TURN_UNIT = float(np.radians(10))  # rotation from the typical one
EXPRESSION_UNIT = 120.0  # FAPU units, mean distance from the typical positions
LID_UNIT = 0.4  # of the neutral eye opening, wider or narrower
SPEED_TURN_UNIT, SPEED_EXPRESSION_UNIT = 1.3, 1800.0  # rad/s, FAPU units/s
TEXTURE_UNIT = 0.12  # of skin_texture_residual
SHARPNESS_WEIGHT = 0.2  # subtracted for each factor of e in sharpness
SAMPLE_INTERVAL_S = 0.2
SAMPLES = 100  # 20 s
NEUTRAL_SAMPLES = 3  # assumed at the start


class TypicalPose:
    """The median head rotation and expression of the last 20 s.

    rotation : (3,) rad; displacements : (n, 2) FAPU units, x and y
    """

    def __init__(self) -> None:
        self.rotation, self.displacements = np.zeros(3), np.zeros((CONTROL_POINT_COUNT, 2))
        neutral = np.zeros(3 + self.displacements.size)
        self._samples = deque([neutral] * NEUTRAL_SAMPLES, maxlen=SAMPLES)
        self._due = float("-inf")

    def sample(self, motion: MotionFrame, now: float, /) -> None:
        """Add a frame's motion if a sample is due at `now`, seconds."""
        if now < self._due:
            return
        self._due = now + SAMPLE_INTERVAL_S
        self._samples.append(np.concatenate([motion.pose[:3], motion.displacements[:, :2].ravel()]))
        median = np.median(self._samples, axis=0)
        self.rotation, self.displacements = median[:3], median[3:].reshape(-1, 2)


def motion_penalty(motion: MotionFrame, typical: TypicalPose, /) -> float:
    """Return the penalty of rotation, expression and lids."""
    d = motion.displacements
    lids = float(np.abs(d[UPPER, 1] - d[LOWER, 1]).max())
    turn = float(np.linalg.norm(motion.pose[:3] - typical.rotation))
    expression = float(np.linalg.norm(d[:, :2] - typical.displacements, axis=1).mean())
    return turn / TURN_UNIT + expression / EXPRESSION_UNIT + lids / UNITS_PER_DISTANCE / LID_UNIT


def speed_penalty(previous: MotionFrame, motion: MotionFrame, /) -> float:
    """Return the penalty of speed: a fast face is blurred, and the smoothed motion lags behind it."""
    elapsed = motion.timestamp - previous.timestamp
    if elapsed <= 0:
        return 0.0
    turn = float(np.linalg.norm(motion.pose[:3] - previous.pose[:3]))
    expression = float(np.linalg.norm((motion.displacements - previous.displacements)[:, :2], axis=1).mean())
    return (turn / SPEED_TURN_UNIT + expression / SPEED_EXPRESSION_UNIT) / elapsed


def image_penalty(pixels: NDArray[np.uint8], landmarks: NDArray[np.floating], /) -> float:
    """Return the penalty of covered skin, less a bonus for sharpness. Compare frames of one person and camera only.

    pixels : (H, W, 3) uint8 BGR; landmarks : (478, 3) px
    """
    bonus = SHARPNESS_WEIGHT * float(np.log1p(sharpness(pixels, landmarks)))
    return skin_texture_residual(pixels, landmarks) / TEXTURE_UNIT - bonus


def sharpness(pixels: NDArray[np.uint8], landmarks: NDArray[np.floating], /) -> float:
    """Return the mean square of the face's Laplacian. Compare frames of one camera only.

    pixels : (H, W, 3) uint8 BGR; landmarks : (478, 3) px
    """
    height, width = pixels.shape[:2]
    low = np.clip(landmarks[:, :2].min(axis=0), 0, (width - 2, height - 2)).astype(int)
    high = np.clip(landmarks[:, :2].max(axis=0), low + 2, (width, height)).astype(int)
    face = cv2.cvtColor(pixels[low[1] : high[1], low[0] : high[0]], cv2.COLOR_BGR2GRAY)
    return float(np.mean(np.square(cv2.Laplacian(face, cv2.CV_32F))))
