"""Fill in what a photo does not show: the background behind the person, and a margin beyond the border."""

import cv2
import numpy as np
from numpy.typing import NDArray

from conf.face.portrait.photo_mesh import BORDER_EXTENSION

FEATHER = 0.006  # image heights: standard deviation of the blur of the person's edge
UNCERTAIN_BAND = 0.03  # image heights around the person that may hold parts of the person; no source of background


def person_mask(outline: NDArray[np.float64], size: tuple[int, int], /) -> NDArray[np.uint8]:
    """Return (H, W) uint8: 255 is person, 0 is background.

    outline : (K, 2) 0 to 1 from the upper left corner; with fewer than three points all is person
    size : width and height in pixels
    """
    width, height = size
    if len(outline) < 3:
        return np.full((height, width), 255, np.uint8)
    mask = np.zeros((height, width), np.uint8)
    corners = np.rint(outline * (width * 16, height * 16)).astype(np.int32)
    cv2.fillPoly(mask, [corners[:, None]], 255, lineType=cv2.LINE_AA, shift=4)
    return np.asarray(cv2.GaussianBlur(mask, (0, 0), max(FEATHER * height, 0.5)), dtype=np.uint8)


def sure_background(person: NDArray[np.uint8], /) -> NDArray[np.bool_]:
    """Return (H, W): True outside the person and the uncertain band. person : (H, W) uint8, from person_mask"""
    radius = max(1, round(UNCERTAIN_BAND * len(person)))
    disk = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * radius + 1, 2 * radius + 1))
    return np.asarray(cv2.dilate((person > 127).astype(np.uint8), disk) == 0)


def inpaint_background(pixels: NDArray[np.uint8], person: NDArray[np.uint8], /) -> NDArray[np.uint8]:
    """Return the image (H, W, 3) with the person replaced by the surrounding colours, smoother towards the middle.

    person : (H, W) uint8, from person_mask
    """
    known = sure_background(person)
    if not known.any():
        return pixels
    return np.asarray(np.clip(push_pull_fill(pixels.astype(np.float32), known), 0, 255), dtype=np.uint8)


def extend_border(
    colours: NDArray[np.uint8], alpha: NDArray[np.uint8], /
) -> tuple[NDArray[np.uint8], NDArray[np.uint8], NDArray[np.float64]]:
    """Return colours and alpha with a margin on all sides, and (2,) the margin as fractions of width and height.

    The margin is smoother the farther out: replicated pixels would show as streaks where a head is cut off.

    colours : (H, W, 3) uint8; alpha : (H, W) uint8
    """
    height, width = alpha.shape
    margin = int(np.ceil(BORDER_EXTENSION * height))
    values = np.pad(np.dstack([colours, alpha]).astype(np.float32), ((margin, margin), (margin, margin), (0, 0)))
    known = np.pad(np.ones((height, width), bool), margin)
    filled = np.clip(np.rint(push_pull_fill(values, known)), 0, 255).astype(np.uint8)
    return filled[..., :3], filled[..., 3], np.array([margin / width, margin / height])


def push_pull_fill(values: NDArray[np.float32], known: NDArray[np.bool_], /) -> NDArray[np.float32]:
    """Return (H, W, k): the values where known, (H, W), is True, and a smooth interpolation elsewhere.

    Source: Gortler et al. 1996 (push and pull).
    """
    height, width = known.shape
    weight = known.astype(np.float32)
    weighted = values * weight[..., None]
    if min(height, width) <= 2:
        mean = weighted.sum(axis=(0, 1)) / max(float(weight.sum()), 1e-6)
        return np.asarray(np.where(known[..., None], values, mean), dtype=np.float32)
    half = (max(1, width // 2), max(1, height // 2))
    half_weight = cv2.resize(weight, half, interpolation=cv2.INTER_AREA)
    half_values = _resize(weighted, half, cv2.INTER_AREA) / np.maximum(half_weight, 1e-6)[..., None]
    coarse = push_pull_fill(np.asarray(half_values, np.float32), np.asarray(half_weight > 1e-3))
    fine = _resize(coarse, (width, height), cv2.INTER_LINEAR)
    return np.asarray(np.where(known[..., None], values, fine), dtype=np.float32)


def _resize(values: NDArray[np.float32], size: tuple[int, int], interpolation: int) -> NDArray[np.float32]:
    """Return values (H, W, k) at another size, width and height. OpenCV drops the last axis if k is 1."""
    resized = np.asarray(cv2.resize(values, size, interpolation=interpolation), np.float32)
    return resized if resized.ndim == 3 else resized[..., None]
