"""The camera's newest image, small and mirrored, on its way from the thread that captures to the window."""

import cv2
import numpy as np
from numpy.typing import NDArray

from conf.sender.capture.frame import Frame
from conf.sender.tracking.tracker import TrackedFace

HEIGHT = 240  # px: more than the corner of a window shows


class SelfView:
    """What one sees of oneself, as in a mirror.

    image : (H, W, 3) uint8 BGR, never changed after it is set; None before the first frame
    """

    def __init__(self) -> None:
        self.image: NDArray[np.uint8] | None = None

    def show(self, frame: Frame, _tracked: TrackedFace | None) -> None:
        """Keep a frame. Called by the thread that captures."""
        height, width = frame.pixels.shape[:2]
        scale = min(HEIGHT / height, 1.0)
        size = (max(round(width * scale), 1), max(round(height * scale), 1))
        small = frame.pixels if scale == 1.0 else cv2.resize(frame.pixels, size, interpolation=cv2.INTER_AREA)
        self.image = np.ascontiguousarray(small[:, ::-1], dtype=np.uint8)

    def clear(self) -> None:
        """Show nothing: the camera is off."""
        self.image = None
