"""Detect that lighting or head position have persistently changed since the photo.

Strategy: twice a second, measure the skin colour in each quarter of the face, located by the motion, and the head pose.
The median of several seconds is compared with the photo, and only if most samples agree with it: a flickering lamp, a
cloud or a short lean cause no new photo.
"""

from collections import deque

import numpy as np
from numpy.typing import NDArray

from conf.face.head_pose import HeadPose
from conf.face.portrait.warp import PortraitWarp
from conf.protocol.messages import MotionFrame
from conf.sender.portrait.occlusion import rigid_skin, sample_blurred

SAMPLE_INTERVAL_S = 0.5
LIGHT_SAMPLES = 10  # 5 s
POSE_SAMPLES = 20  # 10 s: people lean and turn for longer than lamps flicker
AGREEING_QUANTILE = 0.75  # of the samples must be nearer to their median than
MAX_SPREAD_RATIO = 0.5  # of the median's distance from the photo
LIGHT_CHANGE = 0.16  # RMS change of the skin's logarithmic colour
# A photo shows the face badly beyond these changes of pose: 3 rotations, rad; 2 shifts, image heights; log scale.
POSE_CHANGE = np.array([0.4, 0.4, 0.4, 0.22, 0.22, 0.33])
MAX_LIGHT_TURN = 0.35  # rad from the photo: beyond it the quarters of the face show other skin
_FLOOR = 8.0  # of 255, added to colours: below it the logarithm is mostly noise
_BLUR_CM = 0.5


class SceneChangeDetector:
    """Compares frames with one photo."""

    def __init__(self, warp: PortraitWarp, pixels: NDArray[np.uint8], /) -> None:
        """pixels : (H, W, 3) uint8 BGR, the frame that the photo shows"""
        self._warp = warp
        skin = rigid_skin(warp)
        upper_right = warp.positions_cm > np.median(warp.positions_cm[skin], axis=0)
        quarters = [skin & (upper_right == (x, y)).all(axis=1) for x in (False, True) for y in (False, True)]
        self._quarters = [quarter for quarter in quarters if quarter.any()]
        self._photo_light = self._skin_colour(pixels, warp.mesh.positions)
        self._photo_pose = warp.shape.pose.to_vector() / POSE_CHANGE
        self._lights: deque[NDArray[np.float64]] = deque(maxlen=LIGHT_SAMPLES)
        self._poses: deque[NDArray[np.float64]] = deque(maxlen=POSE_SAMPLES)
        self._due = float("-inf")

    @property
    def changed(self) -> bool:
        """Whether lighting or head position have persistently changed."""
        max_light = LIGHT_CHANGE * float(np.sqrt(self._photo_light.size))
        light_changed = _has_changed(self._lights, self._photo_light, max_light)
        return light_changed or _has_changed(self._poses, self._photo_pose, 1.0)

    def sample(self, pixels: NDArray[np.uint8], motion: MotionFrame, now: float, /) -> None:
        """Measure a frame (H, W, 3) uint8 BGR if a sample is due at `now`, seconds."""
        if now < self._due:
            return
        self._due = now + SAMPLE_INTERVAL_S
        pose = HeadPose.from_vector(motion.pose)
        self._poses.append(motion.pose / POSE_CHANGE)
        if angle_between(self._warp.shape.pose, pose) < MAX_LIGHT_TURN:
            self._lights.append(self._skin_colour(pixels, self._warp.deform(motion.displacements, pose)))

    def _skin_colour(self, pixels: NDArray[np.uint8], positions: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return (12,): the logarithm of the skin's mean colour in each quarter of the face."""
        colours = sample_blurred(pixels, positions, _BLUR_CM * self._warp.scale)
        quarters = [colours[quarter].mean(axis=0) for quarter in self._quarters]
        return np.asarray(np.log(np.array(quarters) + _FLOOR).ravel(), np.float64)


def angle_between(a: HeadPose, b: HeadPose, /) -> float:
    """Return the angle between the viewing directions of two heads, radians."""
    return float(np.arccos(np.clip(a.matrix()[2] @ b.matrix()[2], -1, 1)))


def _has_changed(samples: deque[NDArray[np.float64]], photo: NDArray[np.float64], limit: float) -> bool:
    if len(samples) < (samples.maxlen or 0):
        return False
    median = np.median(samples, axis=0)
    distance = float(np.linalg.norm(median - photo))
    spread = np.quantile(np.linalg.norm(np.array(samples) - median, axis=1), AGREEING_QUANTILE)
    return bool(distance > limit and spread < MAX_SPREAD_RATIO * distance)
