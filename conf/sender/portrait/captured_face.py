"""A frame with a face in it, from which images of the person are made."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from conf.face.fapu import Fapu


@dataclass(frozen=True)
class CapturedFace:
    """A frame that may become a photo.

    pixels : (H, W, 3) uint8 BGR
    landmarks : (478, 3) px
    neutral : (n, 3) cm in face axes, the control points of the neutral pose in use
    """

    pixels: NDArray[np.uint8]
    landmarks: NDArray[np.floating]
    neutral: NDArray[np.float64]
    fapu: Fapu
