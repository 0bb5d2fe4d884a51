"""A frame: what every source of images gives."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray


class Frame:
    """An image and its time.

    timestamp : seconds: of a camera on the machine's clock, of a clip from its start; never falls
    """

    def __init__(self, pixels: NDArray[np.uint8] | Callable[[], NDArray[np.uint8]], timestamp: float) -> None:
        """pixels : (H, W, 3) uint8 BGR, or what makes them: many frames of a clip are dropped before anybody looks"""
        self.timestamp = timestamp
        self._pixels = pixels

    @property
    def pixels(self) -> NDArray[np.uint8]:
        """The image, (H, W, 3) uint8 BGR. May raise CameraError the first time."""
        if callable(self._pixels):
            self._pixels = self._pixels()
        return self._pixels
