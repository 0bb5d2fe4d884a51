"""How good a portrait a frame would make: neutral, sharp, eyes open, upright, facing the camera, uncovered."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import INDEX
from conf.face.fapu import UNITS_PER_DISTANCE
from conf.protocol.messages import MotionFrame
from conf.sender.portrait.cover import roughness

FRONTAL = np.radians(15)  # a turn or tilt this large costs a whole mark
STIR = 350.0  # FAPU units of mean displacement that cost a whole mark
WIDE = 0.5  # of the eye's opening, either way, that costs a whole mark
GAPE = 600.0  # FAPU units between the lips that cost a whole mark
COVERED = 0.12  # of roughness (conf.sender.portrait.cover) that costs a whole mark
SHARPNESS_WEIGHT = 0.2  # marks for each factor of e in sharpness


@dataclass(frozen=True)
class Qualities:
    """What speaks against a frame, each 0 when perfect and 1 when bad."""

    turn: float
    stir: float
    lids: float
    mouth: float

    @property
    def marks(self) -> float:
        """Return the sum: lower is better."""
        return self.turn + self.stir + self.lids + self.mouth


def judge(motion: MotionFrame, /) -> Qualities:
    """Judge a frame by its motion."""
    d = motion.displacements
    turn = float(np.linalg.norm(motion.pose[:3]))
    lids = [float(d[INDEX[f"eyelid_upper_{s}"], 1] - d[INDEX[f"eyelid_lower_{s}"], 1]) for s in "lr"]
    gap = float(d[INDEX["inner_lip_upper_mid"], 1] - d[INDEX["inner_lip_lower_mid"], 1])
    return Qualities(
        turn=turn / FRONTAL,
        stir=float(np.linalg.norm(d[:, :2], axis=1).mean()) / STIR,
        lids=max(abs(lid) for lid in lids) / UNITS_PER_DISTANCE / WIDE,
        mouth=max(0.0, gap) / GAPE,
    )


def judge_picture(pixels: NDArray[np.uint8], landmarks: NDArray[np.floating], /) -> float:
    """Return the marks of a frame's pixels, lower is better; compare frames of one person and camera only.

    pixels : (H, W, 3) uint8 BGR; landmarks : (478, 3) px
    """
    return roughness(pixels, landmarks) / COVERED - SHARPNESS_WEIGHT * float(np.log1p(sharpness(pixels, landmarks)))


def sharpness(pixels: NDArray[np.uint8], landmarks: NDArray[np.floating], /) -> float:
    """Return how sharp the face is: the mean square of its Laplacian; compare frames of one camera only.

    pixels : (H, W, 3) uint8 BGR; landmarks : (478, 3) px
    """
    height, width = pixels.shape[:2]
    low = np.clip(landmarks[:, :2].min(axis=0), 0, (width - 2, height - 2)).astype(int)
    high = np.clip(landmarks[:, :2].max(axis=0), low + 2, (width, height)).astype(int)
    face = cv2.cvtColor(pixels[low[1] : high[1], low[0] : high[0]], cv2.COLOR_BGR2GRAY)
    return float(np.mean(np.square(cv2.Laplacian(face, cv2.CV_32F))))
