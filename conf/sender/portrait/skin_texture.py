"""Does something lie over the face? Skin is smooth: a hand, a cup or a microphone brings edges to cheeks, jaw and chin.

Strategy: take a slope of brightness off each area; what is left is how rough it is. A beard is rough too, but always
the same: compare frames of one person only.
"""

import cv2
import numpy as np
from numpy.typing import NDArray

FACE_PX = 64.0  # from the forehead to the chin: pores and noise are gone, fingers are not
MIN_AREA_PX = 12  # of an area that can be judged
FOREHEAD, CHIN = 10, 152
SKIN_PATCHES = (
    (117, 118, 101, 36, 205, 207, 187, 123),  # right cheek
    (346, 347, 330, 266, 425, 427, 411, 352),  # left cheek
    (186, 212, 202, 204, 194, 32, 171, 140, 170, 169, 135, 214, 192),  # right jaw
    (410, 432, 422, 424, 418, 262, 396, 369, 395, 394, 364, 434, 416),  # left jaw
    (83, 18, 313, 406, 418, 262, 428, 199, 208, 32, 194, 182),  # chin
)


def skin_texture_residual(pixels: NDArray[np.uint8], landmarks: NDArray[np.floating], /) -> float:
    """Return how far the roughest area of skin is from an even slope, as a share of its brightness.

    pixels : (H, W, 3) uint8 BGR; landmarks : (478, 3) px
    Measured: 0.05 to 0.1 on bare skin, 0.15 with a beard or a half smile, 0.2 to 0.3 with a hand over mouth and chin.
    """
    points = landmarks[:, :2]
    low = np.clip(np.floor(points.min(axis=0)).astype(int), 0, np.array(pixels.shape[1::-1]) - 2)
    high = np.maximum(np.ceil(points.max(axis=0)).astype(int), low + 2)
    face = cv2.cvtColor(pixels[low[1] : high[1], low[0] : high[0]], cv2.COLOR_BGR2GRAY)
    scale = FACE_PX / max(float(np.linalg.norm(points[CHIN] - points[FOREHEAD])), 1.0)
    small = np.asarray(cv2.resize(face, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA), np.float64)
    return max(_unevenness(small, (points[list(area)] - low) * scale) for area in SKIN_PATCHES)


def _unevenness(brightness: NDArray[np.float64], corners: NDArray[np.floating]) -> float:
    inside = np.zeros(brightness.shape, np.uint8)
    cv2.fillConvexPoly(inside, cv2.convexHull(np.rint(corners).astype(np.int32)), 1)
    y, x = np.nonzero(inside)
    if len(y) < MIN_AREA_PX:
        return 0.0
    values = brightness[y, x]
    axes = np.stack([x - x.mean(), y - y.mean(), np.ones(len(x))], axis=1)
    slope, *_ = np.linalg.lstsq(axes, values, rcond=None)
    return float(np.sqrt(np.mean((values - axes @ slope) ** 2)) / max(float(values.mean()), 1.0))
