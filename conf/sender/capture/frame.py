"""A frame: what every source of images gives."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Frame:
    """An image and its time.

    pixels : (H, W, 3) uint8 BGR
    timestamp : seconds: of a camera on the machine's clock, of a clip from its start; never falls
    """

    pixels: NDArray[np.uint8]
    timestamp: float
