"""Is what the camera sees still what the photograph shows? When light or place have changed for good, a new one is due.

Strategy: twice a second, look at the colour of the skin in each quarter of the face, where the motion says it is, and
at where the head is. What counts is the median of some seconds, and only if most of them agree with it: a lamp that
flickers, a cloud, a lean to the side cost nothing.
"""

from collections import deque

import cv2
import numpy as np
from numpy.typing import NDArray

from conf.face.head_pose import HeadPose
from conf.face.portrait.patch_features import FEATURES
from conf.face.portrait.warp import PortraitWarp
from conf.protocol.messages import MotionFrame

EVERY_S = 0.5
LIGHT_SAMPLES = 10  # five seconds
PLACE_LOOKS = 20  # ten: people lean and turn longer than lamps flicker
AGREEING_QUANTILE = 0.75  # of the looks must be this much nearer to their median than that is to the photograph:
MAX_SPREAD_RATIO = 0.5
LIGHT_CHANGE = 0.16  # of the skin's logarithmic colour, root mean square
# What one photograph does not show well: turned, moved, nearer or farther. In radians, picture heights, e-folds.
PLACE_CHANGE = np.array([0.4, 0.4, 0.4, 0.22, 0.22, 0.33])
SEEN_TURN = 0.35  # radians from the photograph beyond which a face's quarters show other skin
_FLOOR = 8.0  # of 255: below it a logarithm is noise
_BLUR_CM = 0.5


class SceneChangeDetector:
    """Compares what the camera sees with one photograph."""

    def __init__(self, warp: PortraitWarp, pixels: NDArray[np.uint8], /) -> None:
        """pixels : (H, W, 3) uint8 BGR, the frame that the photograph was made of."""
        self._warp = warp
        moving = np.max([feature.weights(warp.positions_cm) for feature in FEATURES], axis=0)
        skin = (moving < 0.05) & warp.on_face
        middle = np.median(warp.positions_cm[skin], axis=0)
        sides = warp.positions_cm > middle
        quarters = [skin & (sides == (x, y)).all(axis=1) for x in (False, True) for y in (False, True)]
        self._quarters = [quarter for quarter in quarters if quarter.any()]
        self._photo_light = self._light(pixels, warp.mesh.positions)
        self._photo_pose = warp.shape.pose.to_vector()
        self._lights: deque[NDArray[np.float64]] = deque(maxlen=LIGHT_SAMPLES)
        self._poses: deque[NDArray[np.float64]] = deque(maxlen=PLACE_LOOKS)
        self._due = float("-inf")

    @property
    def changed(self) -> bool:
        """Whether light or place have changed for good."""
        light = self._changed_persistently(
            self._lights, self._photo_light, LIGHT_CHANGE * float(np.sqrt(self._photo_light.size))
        )
        return light or self._changed_persistently(self._poses, self._photo_pose / PLACE_CHANGE, 1.0)

    def sample(self, pixels: NDArray[np.uint8], motion: MotionFrame, now: float, /) -> None:
        """Take a look, if it is time for one."""
        if now < self._due:
            return
        self._due = now + EVERY_S
        pose = HeadPose.from_vector(motion.pose)
        self._poses.append(motion.pose / PLACE_CHANGE)
        ahead = float(self._warp.shape.pose.matrix()[2] @ pose.matrix()[2])
        if np.arccos(np.clip(ahead, -1, 1)) < SEEN_TURN:
            self._lights.append(self._light(pixels, self._warp.deform(motion.displacements, pose)))

    @staticmethod
    def _changed_persistently(looks: deque[NDArray[np.float64]], photo: NDArray[np.float64], limit: float) -> bool:
        if len(looks) < (looks.maxlen or 0):
            return False
        usual = np.median(looks, axis=0)
        away = float(np.linalg.norm(usual - photo))
        spread = np.quantile(np.linalg.norm(np.array(looks) - usual, axis=1), AGREEING_QUANTILE)
        return bool(away > limit and spread < MAX_SPREAD_RATIO * away)

    def _light(self, pixels: NDArray[np.uint8], places: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return (12,): the logarithm of the skin's mean colour in each quarter of the face."""
        height, width = pixels.shape[:2]
        at = (places * (height, -height) + (width / 2, height / 2) - 0.5).astype(np.float32)
        blur = max(0.5, _BLUR_CM * float(np.exp(self._warp.shape.pose.log_scale)) * height)
        soft = np.asarray(cv2.GaussianBlur(pixels, (0, 0), blur), np.uint8)
        quarters = [_colours(soft, at[quarter]).mean(axis=0) for quarter in self._quarters]
        return np.asarray(np.log(np.array(quarters) + _FLOOR).ravel(), np.float64)


def _colours(pixels: NDArray[np.uint8], at: NDArray[np.float32]) -> NDArray[np.float64]:
    """Return the colours (k, 3) at (k, 2) px."""
    values = cv2.remap(pixels, at[:, None, 0], at[:, None, 1], cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return np.asarray(values[:, 0], dtype=np.float64)
