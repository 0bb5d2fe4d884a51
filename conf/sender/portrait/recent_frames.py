"""Keep the frames of the last seconds, reduced to the size of a photo: for averages, views and patches."""

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import cv2
import numpy as np
from numpy.typing import NDArray

from conf.face.head_pose import HeadPose
from conf.face.portrait.patch_features import FEATURES
from conf.protocol.messages import MotionFrame
from conf.sender.portrait.captured_face import CapturedFace

SAMPLE_INTERVAL_S = 0.15
MAX_FRAMES = 64  # 10 s; 15 MB at 320x240
MAX_PENALTY = 1.5  # of image_penalty above another frame's: a hand covers the face
AVERAGED = 16  # frames of a photo


@dataclass(frozen=True, eq=False)
class RecentFrame:
    """A frame of the last seconds.

    pixels : (h, w, 3) uint8 BGR, at most the height of a photo
    landmarks : (478, 3) px
    penalty : of the image and the face's speed, see `photo_quality`
    descriptors : of each of FEATURES, (k,) each
    """

    pixels: NDArray[np.uint8]
    landmarks: NDArray[np.floating]
    motion: MotionFrame
    penalty: float
    descriptors: tuple[NDArray[np.int8], ...]

    @classmethod
    def reduced(cls, face: CapturedFace, motion: MotionFrame, penalty: float, max_height: int) -> Self:
        """Return a captured face and its motion, reduced to max_height px."""
        pixels = reduce_height(face.pixels, max_height)
        landmarks = face.landmarks * (len(pixels) / len(face.pixels))
        descriptors = tuple(feature.quantised_descriptor(motion.displacements) for feature in FEATURES)
        return cls(pixels, landmarks, motion, penalty, descriptors)

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
        self.last: RecentFrame | None = None  # also if it is not sampled
        self._due = float("-inf")

    def sample(self, face: CapturedFace, motion: MotionFrame, penalty: float, now: float) -> None:
        """Add a frame if a sample is due at `now`, seconds."""
        self.last = RecentFrame.reduced(face, motion, penalty, self._max_height)
        if now < self._due:
            return
        self._due = now + SAMPLE_INTERVAL_S
        self._frames.append(self.last)

    def clear(self) -> None:
        """Drop all frames: they show another scene."""
        self._frames.clear()
        self.last = None

    def all_and_last(self) -> list[RecentFrame]:
        """Return all frames, oldest first, then the very last one: a blink may fall between two samples."""
        frames = list(self._frames)
        return frames if self.last is None or frames[-1:] == [self.last] else [*frames, self.last]

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
