"""Keep the frames of the last seconds, reduced to the size of a photo, to average photos and to choose views."""

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from conf.face.head_pose import HeadPose
from conf.protocol.messages import MotionFrame

SAMPLE_INTERVAL_S = 0.15
MAX_FRAMES = 64  # 10 s; 15 MB at 320x240
MAX_PENALTY = 1.5  # of image_penalty above another frame's: a hand covers the face
AVERAGED = 16  # frames of a photo


@dataclass(frozen=True)
class RecentFrame:
    """A frame of the last seconds.

    pixels : (h, w, 3) uint8 BGR, at most the height of a photo
    penalty : of the image and the face's speed, see `photo_quality`
    """

    pixels: NDArray[np.uint8]
    motion: MotionFrame
    penalty: float

    @property
    def pose(self) -> HeadPose:
        """Return the head pose."""
        return HeadPose.from_vector(self.motion.pose)


class RecentFrames:
    """The frames of the last seconds, SAMPLE_INTERVAL_S apart."""

    def __init__(self, max_height: int) -> None:
        """max_height : px, of a photo; larger frames are reduced"""
        self._max_height = max_height
        self._frames: deque[RecentFrame] = deque(maxlen=MAX_FRAMES)
        self._due = float("-inf")

    def sample(self, pixels: NDArray[np.uint8], motion: MotionFrame, penalty: float, now: float) -> None:
        """Add a frame (H, W, 3) uint8 BGR if a sample is due at `now`, seconds."""
        if now < self._due:
            return
        self._due = now + SAMPLE_INTERVAL_S
        self._frames.append(RecentFrame(reduce_height(pixels, self._max_height), motion, penalty))

    def clear(self) -> None:
        """Drop all frames: they show another scene."""
        self._frames.clear()

    def like(self, penalty: float) -> list[RecentFrame]:
        """Return the frames that are not much worse than one of this penalty, oldest first."""
        return [frame for frame in self._frames if frame.penalty < penalty + MAX_PENALTY]

    def clear_ones(self) -> list[RecentFrame]:
        """Return the frames that are not much worse than the best, oldest first."""
        return self.like(min((frame.penalty for frame in self._frames), default=0.0))


def nearest(frames: Sequence[RecentFrame], /) -> list[RecentFrame]:
    """Return the first AVERAGED of frames that are ordered by their distance."""
    return list(frames[:AVERAGED])


def evenly_spaced(frames: Sequence[RecentFrame], /) -> list[RecentFrame]:
    """Return at most AVERAGED of the frames, evenly spaced, with the last one."""
    step = -(-len(frames) // AVERAGED) or 1
    return list(frames[::-1][::step][::-1])


def reduce_height(pixels: NDArray[np.uint8], max_height: int, /) -> NDArray[np.uint8]:
    """Return an image (H, W, 3), reduced to max_height px if it is higher."""
    height, width = pixels.shape[:2]
    if height <= max_height:
        return pixels
    size = round(width * max_height / height), max_height
    return np.asarray(cv2.resize(pixels, size, interpolation=cv2.INTER_AREA), np.uint8)
