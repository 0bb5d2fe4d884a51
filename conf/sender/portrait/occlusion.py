"""Does the moved photograph still look like the person? If not, something lies over the face: no patch from there.

Strategy: look at some hundred places of skin around mouth and eyes, in the photograph and where the motion puts them in
the frame. Light may differ, so only the pattern of bright and dark counts.
"""

import cv2
import numpy as np
from numpy.typing import NDArray

from conf.face.head_pose import HeadPose
from conf.face.portrait.patch_features import FEATURES
from conf.face.portrait.warp import PortraitWarp

NEAR_CM = 3.2  # around a feature: the skin that tells whether it is covered
BLUR_CM = 0.25


class AppearanceMatcher:
    """Compares frames with one photograph."""

    def __init__(self, warp: PortraitWarp, pixels: NDArray[np.uint8], /) -> None:
        """pixels : (H, W, 3) uint8 BGR, the frame that the photograph was made of."""
        self._warp = warp
        moving = np.max([feature.weights(warp.positions_cm) for feature in FEATURES], axis=0)
        skin = (moving < 0.05) & warp.on_face
        self._near = [skin & feature.near(warp.positions_cm, NEAR_CM) for feature in FEATURES]
        self._photo = [_brightness(pixels, warp, warp.mesh.positions[near]) for near in self._near]

    def region_correlations(
        self, pixels: NDArray[np.uint8], displacements: NDArray[np.floating], pose: HeadPose, /
    ) -> list[float]:
        """Return, for each feature, how the brightness of the skin around it correlates with the photograph's."""
        places = self._warp.deform(displacements, pose)
        pairs = zip(self._near, self._photo, strict=True)
        return [_correlation(photo, _brightness(pixels, self._warp, places[near])) for near, photo in pairs]


def _brightness(pixels: NDArray[np.uint8], warp: PortraitWarp, places: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the brightness (k,), 0 to 255, of places (k, 2) in picture heights."""
    height, width = pixels.shape[:2]
    grey = cv2.cvtColor(pixels, cv2.COLOR_BGR2GRAY)
    grey = cv2.GaussianBlur(grey, (0, 0), max(0.5, BLUR_CM * float(np.exp(warp.shape.pose.log_scale)) * height))
    at = (places * (height, -height) + (width / 2, height / 2) - 0.5).astype(np.float32)
    values = cv2.remap(grey, at[:, None, 0], at[:, None, 1], cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return np.asarray(values[:, 0], dtype=np.float64)


def _correlation(photo: NDArray[np.float64], frame: NDArray[np.float64]) -> float:
    a, b = photo - photo.mean(), frame - frame.mean()
    return float(a @ b / max(np.sqrt(float(a @ a) * float(b @ b)), 1e-9))
