"""Part a photograph into the person and what is behind: an outline says where, and what it hid is filled in."""

import cv2
import numpy as np
from numpy.typing import NDArray

FEATHER = 0.006  # picture heights over which the person's edge fades
UNCERTAIN_BAND = 0.03  # picture heights about the person that may hold some of him: not used for the background


def person_mask(outline: NDArray[np.float64], size: tuple[int, int], /) -> NDArray[np.uint8]:
    """Return (H, W) uint8: 255 is person, 0 is background.

    outline : (K, 2) 0 to 1 from the upper left corner; fewer than three points: all is person
    size : width and height in pixels
    """
    width, height = size
    if len(outline) < 3:
        return np.full((height, width), 255, np.uint8)
    share = np.zeros((height, width), np.uint8)
    corners = np.rint(outline * (width * 16, height * 16)).astype(np.int32)
    cv2.fillPoly(share, [corners[:, None]], 255, lineType=cv2.LINE_AA, shift=4)
    return np.asarray(cv2.GaussianBlur(share, (0, 0), max(FEATHER * height, 0.5)), dtype=np.uint8)


def sure_background(person: NDArray[np.uint8], /) -> NDArray[np.bool_]:
    """Return (H, W): where there is surely none of the person. person : (H, W) uint8, as `person_share`."""
    reach = max(1, round(UNCERTAIN_BAND * len(person)))
    around = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * reach + 1, 2 * reach + 1))
    return np.asarray(cv2.dilate((person > 127).astype(np.uint8), around) == 0)


def inpaint_background(pixels: NDArray[np.uint8], person: NDArray[np.uint8], /) -> NDArray[np.uint8]:
    """Return the picture (H, W, 3) with the person gone: colours flow in from around, softer the farther in.

    person : (H, W) uint8, as `person_share`
    """
    known = sure_background(person)
    if not known.any():
        return pixels
    return np.asarray(np.clip(push_pull_fill(pixels.astype(np.float32), known), 0, 255), dtype=np.uint8)


def push_pull_fill(values: NDArray[np.float32], known: NDArray[np.bool_], /) -> NDArray[np.float32]:
    """Return the values (H, W, k) where they are known, (H, W), and a smooth guess from around where they are not.

    Source: Gortler et al. 1996 (push and pull).
    """
    height, width = known.shape
    weight = known.astype(np.float32)
    mine = values * weight[..., None]
    if min(height, width) <= 2:
        mean = mine.sum(axis=(0, 1)) / max(float(weight.sum()), 1e-6)
        return np.asarray(np.where(known[..., None], values, mean), dtype=np.float32)
    half = (max(1, width // 2), max(1, height // 2))
    small_weight = cv2.resize(weight, half, interpolation=cv2.INTER_AREA)
    small = _resize(mine, half, cv2.INTER_AREA) / np.maximum(small_weight, 1e-6)[..., None]
    below = push_pull_fill(np.asarray(small, np.float32), np.asarray(small_weight > 1e-3))
    guess = _resize(below, (width, height), cv2.INTER_LINEAR)
    return np.asarray(np.where(known[..., None], values, guess), dtype=np.float32)


def _resize(values: NDArray[np.float32], size: tuple[int, int], how: int) -> NDArray[np.float32]:
    """Return values (H, W, k) in another size, width and height: OpenCV drops the last axis where k is 1."""
    sized = np.asarray(cv2.resize(values, size, interpolation=how), np.float32)
    return sized if sized.ndim == 3 else sized[..., None]
