"""Fill in the background behind the person."""

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d

from conf.face.interpolation import smoothstep

FEATHER = 0.006  # image heights: standard deviation of the blur of the person's edge
TEXTURE_SIGMA = 0.05  # image heights: what a blur of this standard deviation removes is texture
TEXTURE_DEPTH = 0.12  # image heights behind the person, over which texture sets in: at the edge it would not fit
HEAD_QUANTILE = 0.35  # of the person's widths in all rows: about the head's
CLONE_FEATHER = 0.03  # image heights, over which copies of the texture overlap
CLONE_STEPS = (1.0, 1.35, 1.8, 2.4, 3.2)  # of the head's width, tried in this order
CLONE_BLEND = 0.3  # of the head's width, over which the side changes from which texture is copied
OUTLINE_BAND = 0.024  # image heights around the outline that may show the person: it is some pixels off
UNCERTAIN_BAND = 0.04  # the same where colours are the person's: strands of hair
HAIR_CONTRAST = 4.0  # of the squared distances to the person's and the background's colour: above it is background


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


def sure_background(pixels: NDArray[np.uint8], person: NDArray[np.uint8], /) -> NDArray[np.bool_]:
    """Return (H, W): True outside the person and the pixels around it that may show parts of it.

    Those are all near the outline, and farther out, where hair is, the ones whose colour is rather the person's.

    pixels : (H, W, 3) uint8 BGR; person : (H, W) uint8, from person_mask
    """
    inside = (person > 127).astype(np.uint8)
    distance = cv2.distanceTransform(1 - inside, cv2.DIST_L2, 5) / len(person)
    beyond = (distance > UNCERTAIN_BAND) & (inside == 0)
    if not beyond.any() or not inside.any():
        return np.asarray(beyond)
    near = ~beyond & (distance > OUTLINE_BAND)
    image = pixels.astype(np.float32)
    to_person, to_background = (
        np.sum(np.square(image - push_pull_fill(image, known)), axis=2)
        for known in (cv2.erode(inside, np.ones((3, 3), np.uint8)) > 0, beyond)
    )
    return np.asarray(beyond | (near & (to_person > HAIR_CONTRAST * to_background)))


def inpaint_background(pixels: NDArray[np.uint8], known: NDArray[np.bool_], /) -> NDArray[np.uint8]:
    """Return the image (H, W, 3) with the person replaced by a plausible background.

    Its colours are interpolated between those around the person. Behind the person's edge texture is added that is
    copied from beside the person.

    known : (H, W) bool, from sure_background
    """
    if not known.any() or known.all():
        return pixels
    image = pixels.astype(np.float32)
    smooth = _blur_known(image, known)
    texture, weight = _clone_beside(image - smooth, known)
    depth = cv2.distanceTransform((~known).astype(np.uint8), cv2.DIST_L2, 3) / (TEXTURE_DEPTH * len(known))
    weight = (weight * smoothstep(depth).astype(np.float32))[..., None]
    plain = push_pull_fill(image, known)
    filled = plain + (push_pull_fill(smooth, known) + texture - plain) * weight
    return np.asarray(np.clip(filled, 0, 255), dtype=np.uint8)


def _blur_known(image: NDArray[np.float32], known: NDArray[np.bool_]) -> NDArray[np.float32]:
    """Return the image (H, W, 3) blurred by TEXTURE_SIGMA, where known, from known pixels only."""
    sigma = max(0.5, TEXTURE_SIGMA * len(image))
    weight = cv2.GaussianBlur(known.astype(np.float32), (0, 0), sigma)
    blurred = cv2.GaussianBlur(image * known[..., None], (0, 0), sigma)
    return np.asarray(blurred / np.maximum(weight, 1e-3)[..., None], np.float32)


def _clone_beside(
    texture: NDArray[np.float32], known: NDArray[np.bool_]
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Return the texture (H, W, 3) copied from known pixels, (H, W) bool, to the others, and its weight (H, W), 0 to 1.

    It is copied along rows by the smallest of some distances that lead out of the person, towards the nearer side. It
    is only as strong as on the other side: what stands out on one side alone is an object, not a texture.
    """
    gaps = np.count_nonzero(~known, axis=1)
    head = float(np.quantile(gaps[gaps > 0], HEAD_QUANTILE))
    depth = cv2.distanceTransform(known.astype(np.uint8), cv2.DIST_L2, 3) / max(1.0, CLONE_FEATHER * len(known))
    available = np.clip(depth, 0, 1).astype(np.float32)
    centre, columns = np.mean(np.nonzero(~known)[1]), np.arange(known.shape[1])
    left = smoothstep((centre - columns) / (CLONE_BLEND * head) + 0.5).astype(np.float32)
    strengths = [_row_strength(texture, known & side) for side in (columns < centre, columns >= centre)]
    copied, weight, everywhere = np.zeros_like(texture), np.zeros_like(available), np.ones_like(left)
    for factor in CLONE_STEPS:
        step = round(head * factor)
        for shift, side in ((step, left), (-step, 1 - left), (step, everywhere), (-step, everywhere)):
            added = _shift(available, shift) * side * (1 - weight)
            own = strengths[0 if shift > 0 else 1]
            copied += _shift(texture, shift) * (added * np.minimum(*strengths) / np.maximum(own, 1e-3))[..., None]
            weight += added
    return copied / np.maximum(weight, 1e-3)[..., None], weight


def _row_strength(texture: NDArray[np.float32], where: NDArray[np.bool_]) -> NDArray[np.float32]:
    """Return (H, 1): the root mean square of a texture (H, W, 3) in and around each row, in a mask (H, W)."""
    sigma = max(0.5, TEXTURE_SIGMA * len(texture))
    energy = np.mean(np.square(texture), axis=2)
    sums = np.stack([np.sum(values, axis=1, where=where) for values in (energy, np.ones_like(energy))])
    total, count = gaussian_filter1d(sums, sigma, axis=1)[..., None]
    return np.asarray(np.sqrt(total / np.maximum(count, 1e-3)), np.float32)


def _shift(values: NDArray[np.float32], columns: int) -> NDArray[np.float32]:
    """Return an array (H, W) or (H, W, 3) moved to the right by some columns, 0 where nothing comes from."""
    moved = np.zeros_like(values)
    width = values.shape[1]
    if abs(columns) < width:
        moved[:, max(columns, 0) : width + min(columns, 0)] = values[:, max(-columns, 0) : width - max(columns, 0)]
    return moved


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
