"""Image matting: the person's alpha and colour at each pixel, separated from the background.

An outline of some dozen corners is a few pixels off and misses single hairs. Near it a pixel is a mixture of the
person's colour, extrapolated from inside, and the background's, extrapolated from outside. Alpha is the pixel's
position between the two. Where the background varies too much for that, alpha follows the outline. Then the
background's part is subtracted from the colour: composited over the inpainted background the person yields the photo
again, and composited elsewhere shows no rim of the old background.
Source: Chuang et al. 2001 (Bayesian matting), simplified to one colour for each side.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from conf.receiver.portrait.inpainting import inpaint_background, push_pull_fill, sure_background

SURE_FOREGROUND = 0.02  # image heights inside the outline; farther in everything is person
VARIANCE_SIGMA = 0.012  # image heights: neighbourhood in which the background's variance is measured
# Weight of the outline against the colours, grey levels squared: a constant, a term for each squared grey level of the
# background's variance, and one for each of the distance to the line between the two colours, as at a window.
PRIOR_WEIGHT = 300.0
VARIANCE_WEIGHT = 8.0
RESIDUAL_WEIGHT = 4.0
MIN_RELIABLE_ALPHA = 0.5  # from here on the unmixed colour is used alone; below, blended with the extrapolated one
FADE = 0.012  # image heights: alpha fades to 0 over it, towards the sure background

Image = NDArray[np.float32]


@dataclass(frozen=True)
class Matte:
    """A person without background, and the background without the person.

    colours : (H, W, 3) uint8 BGR of the person
    alpha : (H, W) uint8 of the person
    backdrop : (H, W, 3) uint8 BGR
    """

    colours: NDArray[np.uint8]
    alpha: NDArray[np.uint8]
    backdrop: NDArray[np.uint8]


def estimate_matte(pixels: NDArray[np.uint8], person: NDArray[np.uint8], /) -> Matte:
    """Return the matte of an image (H, W, 3) uint8 BGR. person : (H, W) uint8, from person_mask"""
    outside, inside = sure_background(pixels, person), _sure_foreground(person)
    backdrop = inpaint_background(pixels, outside)
    if not outside.any() or not inside.any():
        return Matte(pixels, person, backdrop)
    image, background = pixels.astype(np.float32), backdrop.astype(np.float32)
    foreground = push_pull_fill(image, inside)
    prior = person.astype(np.float32) / np.float32(255)
    alpha = _alpha(image, foreground, background, prior=prior, variance=_background_variance(image, outside))
    alpha = np.asarray(cv2.GaussianBlur(np.where(inside, 1, alpha), (0, 0), 0.7), np.float32) * _fade(outside)
    layer = alpha[..., None]
    colours = (image - (1 - layer) * background) / np.maximum(layer, MIN_RELIABLE_ALPHA / 8)
    reliable = np.clip(layer / MIN_RELIABLE_ALPHA, 0, 1)
    colours = foreground + reliable * (np.clip(colours, 0, 255) - foreground)
    return Matte(_to_bytes(colours), _to_bytes(alpha * 255), backdrop)


def _alpha(image: Image, foreground: Image, background: Image, *, prior: Image, variance: Image) -> Image:
    """Return (H, W), 0 to 1: the position of each colour between the background's and the person's."""
    axis, offset = foreground - background, image - background
    along, length = np.sum(offset * axis, axis=2), np.sum(axis * axis, axis=2)
    nearest = np.clip(along / np.maximum(length, 1), 0, 1)[..., None]
    residual = np.sum(np.square(offset - nearest * axis), axis=2)
    weight = PRIOR_WEIGHT + VARIANCE_WEIGHT * variance + RESIDUAL_WEIGHT * residual
    return np.asarray(np.clip((along + weight * prior) / (length + weight), 0, 1), np.float32)


def _background_variance(image: Image, outside: NDArray[np.bool_]) -> Image:
    """Return (H, W): the local variance of the background's colours, squared grey levels."""
    sigma = max(0.5, VARIANCE_SIGMA * len(image))
    weight = cv2.GaussianBlur(outside.astype(np.float32), (0, 0), sigma)
    known = image * outside[..., None]
    mean = cv2.GaussianBlur(known, (0, 0), sigma) / np.maximum(weight, 1e-3)[..., None]
    square = cv2.GaussianBlur(np.sum(known * image, axis=2), (0, 0), sigma) / np.maximum(weight, 1e-3)
    variance = np.maximum(square - np.sum(mean * mean, axis=2), 0).astype(np.float32)
    enough = weight > min(0.3, float(weight.max()) / 2)
    return push_pull_fill(variance[..., None], np.asarray(enough))[..., 0]


def _sure_foreground(person: NDArray[np.uint8]) -> NDArray[np.bool_]:
    radius = max(1, round(SURE_FOREGROUND * len(person)))
    disk = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * radius + 1, 2 * radius + 1))
    return np.asarray(cv2.erode((person > 127).astype(np.uint8), disk) > 0)


def _fade(outside: NDArray[np.bool_]) -> Image:
    """Return (H, W): 0 in the sure background, rising to 1 over FADE."""
    distance = cv2.distanceTransform((~outside).astype(np.uint8), cv2.DIST_L2, 3)
    return np.asarray(np.clip(distance / max(FADE * len(outside), 1), 0, 1), np.float32)


def _to_bytes(values: NDArray[np.floating]) -> NDArray[np.uint8]:
    return np.asarray(np.clip(np.rint(values), 0, 255), dtype=np.uint8)
