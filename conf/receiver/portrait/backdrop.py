"""Part a photograph into the person and what is behind: an outline says where, and what it hid is filled in."""

import cv2
import numpy as np
from numpy.typing import NDArray

FEATHER = 0.006  # picture heights over which the person's edge fades
FRINGE = 0.025  # picture heights around the person whose colours are mixed with his: not used for the background


def person_share(outline: NDArray[np.float64], size: tuple[int, int], /) -> NDArray[np.uint8]:
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


def fill_behind(pixels: NDArray[np.uint8], person: NDArray[np.uint8], /) -> NDArray[np.uint8]:
    """Return the picture (H, W, 3) with the person gone: colours flow in from around, softer the farther in.

    person : (H, W) uint8, as `person_share`
    Source: Gortler et al. 1996 (push and pull).
    """
    reach = max(1, round(FRINGE * len(pixels)))
    hidden = cv2.dilate((person > 8).astype(np.uint8), np.ones((2 * reach + 1, 2 * reach + 1), np.uint8))
    known = (1 - hidden).astype(np.float32)
    if not known.any():
        return pixels
    filled = _push_pull(pixels.astype(np.float32), known)
    share = known[..., None]
    return np.asarray(np.clip(pixels * share + filled * (1 - share), 0, 255), dtype=np.uint8)


def _push_pull(colour: NDArray[np.float32], weight: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return the colours where they are known, and a smooth guess where not."""
    height, width = weight.shape
    mine = colour * weight[..., None]
    if min(height, width) <= 2:
        mean = mine.sum(axis=(0, 1)) / max(float(weight.sum()), 1e-6)
        return np.asarray(np.where(weight[..., None] > 0, colour, mean), dtype=np.float32)
    half = (max(1, width // 2), max(1, height // 2))
    small_weight = cv2.resize(weight, half, interpolation=cv2.INTER_AREA)
    small = cv2.resize(mine, half, interpolation=cv2.INTER_AREA) / np.maximum(small_weight, 1e-6)[..., None]
    below = _push_pull(np.asarray(small, np.float32), (small_weight > 1e-3).astype(np.float32))
    guess = cv2.resize(below, (width, height), interpolation=cv2.INTER_LINEAR)
    return np.asarray(np.where(weight[..., None] > 0, colour, guess), dtype=np.float32)
