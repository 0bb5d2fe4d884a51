"""The camera's newest image, small and mirrored, on its way from the thread that captures to the window."""

from collections import deque

import cv2
import numpy as np
from numpy.typing import NDArray

from conf.protocol.messages import MotionFrame
from conf.sender.capture.frame import Frame
from conf.sender.tracking.tracker import TrackedFace

HEIGHT = 240  # px: more than the corner of a window shows


class SelfView:
    """What one sees of oneself.

    image : the camera's, as in a mirror: (H, W, 4) uint8 RGBA, never changed after it is set; None before the first
        frame and while the camera is off
    sent : the newest motion sent, None while none is; objects : of the portrait, as they were sent
    """

    def __init__(self, objects: deque[bytes] | None = None) -> None:
        """objects : filled by somebody else, who limits their number"""
        self.image: NDArray[np.uint8] | None = None
        self.sent: MotionFrame | None = None
        self.objects: deque[bytes] = deque() if objects is None else objects

    def show(self, frame: Frame, _tracked: TrackedFace | None) -> None:
        """Keep a frame. Called by the thread that captures."""
        height, width = frame.pixels.shape[:2]
        scale = min(HEIGHT / height, 1.0)
        size = (max(round(width * scale), 1), max(round(height * scale), 1))
        small = frame.pixels if scale == 1.0 else cv2.resize(frame.pixels, size, interpolation=cv2.INTER_AREA)
        self.image = np.asarray(cv2.cvtColor(small[:, ::-1], cv2.COLOR_BGR2RGBA), dtype=np.uint8)

    def clear(self) -> None:
        """Show nothing: the camera is off."""
        self.image = self.sent = None
