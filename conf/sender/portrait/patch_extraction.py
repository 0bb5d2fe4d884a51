"""Cut mouth and eyes from a frame, and encode their residual against the photo as a patch.

Colours are matched on the sender's side, where both images are available: a patch gets the photo's colours along its
border.
"""

from bisect import bisect_left

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from conf.face.control_points import CONTROL_POINT_LANDMARKS
from conf.face.portrait.patch_features import PatchRegion
from conf.face.portrait.patch_prediction import forward_dct
from conf.protocol.portrait.patch import MAX_SIDE, STEP_COUNT, Patch, encode_patch, step_size

MARGIN = 1.1  # of the falloff distance: the crop ends where the patch's weight has become 0
MIN_CROP_PX = 8


def find_crop_box(
    landmarks: NDArray[np.floating], feature: PatchRegion, size: tuple[int, int], /, *, px_per_cm: float
) -> tuple[NDArray[np.intp], NDArray[np.intp], NDArray[np.float64]]:
    """Return a feature's box: corners low and high (2,), px; control points (m, 2) between them, 0 to 1.

    landmarks : (478, 3) px; size : width and height of the frame, px
    """
    centre = landmarks[list(feature.centre_landmarks), :2]
    margin = MARGIN * feature.falloff_cm[1] * px_per_cm
    low = np.maximum(np.floor(centre.min(axis=0) - margin), 0).astype(int)
    high = np.minimum(np.ceil(centre.max(axis=0) + margin), size).astype(int)
    low, high = np.minimum(low, np.array(size) - MIN_CROP_PX), np.maximum(high, low + MIN_CROP_PX)
    points = (landmarks[CONTROL_POINT_LANDMARKS[list(feature.points)], :2] - low) / (high - low)
    return low, high, points.astype(np.float64)


def extract_patch(
    pixels: NDArray[np.uint8], landmarks: NDArray[np.floating], feature: PatchRegion, /, *, px_per_cm: float
) -> tuple[NDArray[np.uint8], NDArray[np.float64], NDArray[np.float64]]:
    """Cut a feature from a frame, reduced to MAX_SIDE px.

    pixels : (H, W, 3) uint8 BGR; landmarks : (478, 3) px
    Returns the crop (h, w, 3), its control points (m, 2), 0 to 1, and the patch's weight over the photo (h, w), 0 to 1.
    """
    low, high, points = find_crop_box(landmarks, feature, (pixels.shape[1], pixels.shape[0]), px_per_cm=px_per_cm)
    crop = pixels[low[1] : high[1], low[0] : high[0]]
    scale = min(1.0, MAX_SIDE / max(crop.shape[:2]))
    small = cv2.resize(crop, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA) if scale < 1 else crop
    rows, columns = small.shape[:2]
    grid = np.stack(np.meshgrid(np.arange(columns) + 0.5, np.arange(rows) + 0.5), axis=-1) / (columns, rows)
    centre = cKDTree(landmarks[list(feature.centre_landmarks), :2])
    distance_cm = np.asarray(centre.query(low + grid * (high - low))[0]) / px_per_cm
    return np.ascontiguousarray(small, np.uint8), points, feature.falloff(distance_cm)


def match_colour(patch: NDArray[np.uint8], predicted: NDArray[np.float64], /) -> NDArray[np.float64]:
    """Return a patch (h, w, 3) scaled, channel by channel, to the prediction's (h, w, 3) mean colour at its border."""
    height, width = patch.shape[:2]
    border = np.ones((height, width), bool)
    inset = max(2, min(height, width) // 7)
    border[inset:-inset, inset:-inset] = False
    gain = predicted[border].mean(axis=0) / np.maximum(patch[border].mean(axis=0), 1)
    return np.asarray(np.clip(patch * np.clip(gain, 0.6, 1.6), 0, 255))


def make_patch(
    residual: NDArray[np.float64],
    points: NDArray[np.float64],
    descriptor: NDArray[np.int8],
    /,
    *,
    target: tuple[int, int, int],
    max_bytes: int,
) -> Patch:
    """Return the patch with the finest quantiser step that fits into `max_bytes`, else the coarsest.

    residual : (h, w, 3), added to the prediction from the photo; points : (m, 2) 0 to 1
    target : photo number, region and slot
    """
    planes = forward_dct(residual)
    size = residual.shape[1], residual.shape[0]

    def quantise(step: int) -> Patch:
        return Patch(*target, descriptor, points, size, step, [plane / step_size(step) for plane in planes])

    finest = bisect_left(range(STEP_COUNT - 1), True, key=lambda step: len(encode_patch(quantise(step))) <= max_bytes)
    return quantise(finest)
