"""Detect that something covers the face: by the texture of the skin, or by comparison with the photo.

Strategy. Skin is smooth; a hand, a cup or a microphone adds edges to cheeks, jaw and chin. After the removal of a
linear brightness gradient, the residual measures texture. A beard has texture too, but always the same: compare frames
of one person only. Where a photo exists, the brightness of some hundred skin points around the eyes is correlated with
the same points of the photo; correlation is independent of lighting. Around the mouth a smile changes the skin more
than that. There the frame is aligned with the photo by the mesh and an optical flow, which finds the folds of a smile
again but not a hand; what a gain and an offset of brightness then leave is the residual.
"""

from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from conf.face.head_pose import HeadPose
from conf.face.portrait.patch_features import FEATURES, MOUTH
from conf.face.portrait.warp import PortraitWarp
from conf.sender.portrait.photo_averaging import MeshAligner
from conf.sender.portrait.recent_frames import RecentFrame, reduce_height

FACE_PX = 64.0  # forehead to chin after scaling: removes pores and noise, keeps fingers
MIN_AREA_PX = 12  # of a skin patch; smaller ones are not judged
FOREHEAD, CHIN = 10, 152  # landmarks
SKIN_PATCHES = (
    (117, 118, 101, 36, 205, 207, 187, 123),  # right cheek
    (346, 347, 330, 266, 425, 427, 411, 352),  # left cheek
    (186, 212, 202, 204, 194, 32, 171, 140, 170, 169, 135, 214, 192),  # right jaw
    (410, 432, 422, 424, 418, 262, 396, 369, 395, 394, 364, 434, 416),  # left jaw
    (83, 18, 313, 406, 418, 262, 428, 199, 208, 32, 194, 182),  # chin
)
NEAR_CM = 3.2  # radius around a feature within which skin shows whether it is covered
BLUR_CM = 0.25
ALIGNED_PX = 120  # image height, of the images that are aligned: skin under a blur needs no more
ALIGNED_SIGMA = 1.0  # px
RESIDUAL_QUANTILE = 0.9  # of the pixels: a hand over a part of the skin is enough


def skin_texture_residual(pixels: NDArray[np.uint8], landmarks: NDArray[np.floating], /) -> float:
    """Return the largest RMS deviation of a skin patch from a linear gradient, relative to its brightness.

    pixels : (H, W, 3) uint8 BGR; landmarks : (478, 3) px
    Measured: 0.05 to 0.1 on bare skin, 0.15 with a beard or a half smile, 0.2 to 0.3 with a hand over mouth and chin.
    """
    points = landmarks[:, :2]
    low = np.clip(np.floor(points.min(axis=0)).astype(int), 0, np.array(pixels.shape[1::-1]) - 2)
    high = np.maximum(np.ceil(points.max(axis=0)).astype(int), low + 2)
    face = cv2.cvtColor(pixels[low[1] : high[1], low[0] : high[0]], cv2.COLOR_BGR2GRAY)
    scale = FACE_PX / max(float(np.linalg.norm(points[CHIN] - points[FOREHEAD])), 1.0)
    small = np.asarray(cv2.resize(face, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA), np.float64)
    return max(_gradient_residual(small, (points[list(patch)] - low) * scale) for patch in SKIN_PATCHES)


def _gradient_residual(brightness: NDArray[np.float64], corners: NDArray[np.floating]) -> float:
    inside = np.zeros(brightness.shape, np.uint8)
    cv2.fillConvexPoly(inside, cv2.convexHull(np.rint(corners).astype(np.int32)), 1)
    y, x = np.nonzero(inside)
    if len(y) < MIN_AREA_PX:
        return 0.0
    values = brightness[y, x]
    axes = np.stack([x - x.mean(), y - y.mean(), np.ones(len(x))], axis=1)
    gradient, *_ = np.linalg.lstsq(axes, values, rcond=None)
    return float(np.sqrt(np.mean((values - axes @ gradient) ** 2)) / max(float(values.mean()), 1.0))


class AppearanceMatcher:
    """Correlates frames with the photo around each feature."""

    def __init__(self, warp: PortraitWarp, pixels: NDArray[np.uint8], /) -> None:
        """pixels : (H, W, 3) uint8 BGR, the frame that the photo shows"""
        self._warp = warp
        skin = rigid_skin(warp)
        self._near = [skin & feature.near(warp.positions_cm, NEAR_CM) for feature in FEATURES]
        self._photo = [self._brightness(pixels, warp.mesh.positions[near]) for near in self._near]

    def correlation(
        self, region: int, pixels: NDArray[np.uint8], displacements: NDArray[np.floating], pose: HeadPose, /
    ) -> float:
        """Return the correlation, -1 to 1, of the skin's brightness around a feature with the photo's.

        region : index into FEATURES; pixels : (H, W, 3) uint8 BGR; displacements : (n, 3) FAPU units
        """
        positions = self._warp.deform(displacements, pose)[self._near[region]]
        photo, frame = self._photo[region], self._brightness(pixels, positions)
        a, b = photo - photo.mean(), frame - frame.mean()
        return float(a @ b / max(np.sqrt(float(a @ a) * float(b @ b)), 1e-9))

    def _brightness(self, pixels: NDArray[np.uint8], positions: NDArray[np.float64]) -> NDArray[np.float64]:
        grey = np.asarray(cv2.cvtColor(pixels, cv2.COLOR_BGR2GRAY), np.uint8)
        return sample_blurred(grey, positions, BLUR_CM * self._warp.scale)


class CoverDetector:
    """Measures what covers the skin around the mouth in later frames."""

    def __init__(self, warp: PortraitWarp, pixels: NDArray[np.uint8], /) -> None:
        """pixels : (H, W, 3) uint8 BGR, the frame that the photo shows"""
        self._photo = reduce_height(pixels, ALIGNED_PX)
        self._aligner = MeshAligner(warp, warp.mesh.positions, (self._photo.shape[1], self._photo.shape[0]))
        near = rigid_skin(warp) & MOUTH.near(warp.positions_cm, NEAR_CM)
        self._near = self._aligner.interpolate(near.astype(np.float64)) > 0.5
        brightness = self._brightness(self._photo)
        self._axes = np.stack([brightness, np.ones_like(brightness)], axis=1)

    def residual(self, frame: RecentFrame) -> float:
        """Return the deviation of nine tenths of the skin from the photo, relative to the brightness; 0 without skin.

        Measured: to 0.16 on bare skin of faces that speak, smile or turn by 22 degrees; 0.18 to 0.39 with a hand over
        the mouth.
        """
        if not self._near.any():
            return 0.0
        size = self._photo.shape[1], self._photo.shape[0]
        pixels = np.asarray(cv2.resize(frame.pixels, size, interpolation=cv2.INTER_AREA), np.uint8)
        aligned, *_ = self._aligner.align(self._photo, replace(frame, pixels=pixels))
        values = self._brightness(aligned)
        fit, *_ = np.linalg.lstsq(self._axes, values, rcond=None)
        deviation = np.quantile(np.abs(values - self._axes @ fit), RESIDUAL_QUANTILE)
        return float(deviation) / max(float(values.mean()), 1.0)

    def _brightness(self, image: NDArray[np.uint8] | NDArray[np.float32]) -> NDArray[np.float64]:
        """Return (k,) the blurred brightness of the skin."""
        grey = cv2.cvtColor(image.astype(np.float32), cv2.COLOR_BGR2GRAY)
        return np.asarray(cv2.GaussianBlur(grey, (0, 0), ALIGNED_SIGMA)[self._near], np.float64)


def rigid_skin(warp: PortraitWarp, /) -> NDArray[np.bool_]:
    """Return (V,) the mesh vertices on the face that no patch covers."""
    moving = np.max([feature.weights(warp.positions_cm) for feature in FEATURES], axis=0)
    return np.asarray((moving < 0.05) & warp.on_face)


def sample_blurred(image: NDArray[np.uint8], positions: NDArray[np.float64], sigma: float, /) -> NDArray[np.float64]:
    """Return the values (k,) or (k, 3), 0 to 255, of a blurred image (H, W) or (H, W, 3).

    positions : (k, 2) image heights, x right, y up, from the middle
    sigma : standard deviation of the blur, image heights; at least 0.5 px is used
    """
    height, width = image.shape[:2]
    blurred = cv2.GaussianBlur(image, (0, 0), max(0.5, sigma * height))
    x, y = (positions * (height, -height) + (width / 2, height / 2) - 0.5).astype(np.float32).T[..., None]
    return np.asarray(cv2.remap(blurred, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)[:, 0], np.float64)
