"""Cut a person out softly: how much of each pixel at the edge is person, and in which colour.

Strategy: an outline of some dozen corners is a few pixels off, and misses single hairs. Near it a pixel is a mixture
of the person's colour, as it is farther in, and the background's, as it is farther out; where it lies on the way from
one to the other tells how much of each there is. Where the background is too uneven to tell, the outline is believed.
Then the background's part is taken out of the colour, so that the person laid over the filled-in background gives the
photograph again, and laid elsewhere carries no rim of the old background along.
Source: Chuang et al. 2001 (Bayesian matting), simplified to one colour for each side.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from conf.receiver.portrait.inpainting import UNCERTAIN_BAND, inpaint_background, push_pull_fill, sure_background

SURE_FOREGROUND = 0.02  # picture heights inside the outline, from where on everything is person
AROUND = 0.012  # picture heights: the neighbourhood in which the background's unevenness is measured
PRIOR_WEIGHT = 300.0  # in the outline, grey levels squared
VARIANCE_WEIGHT = 8.0  # more trust, for each grey level squared of the background's unevenness
RESIDUAL_WEIGHT = (
    4.0  # and for each by which a colour is neither the person's nor the background's, nor between: a window
)
MIN_RELIABLE_ALPHA = (
    0.5  # share from which on the person's own colour is what is left when the background's part is taken out
)
FADE = 0.4  # of the fringe: over it the person ends in any case

Image = NDArray[np.float32]


@dataclass(frozen=True)
class Matte:
    """A person without background, and the background without the person.

    colours : (H, W, 3) uint8 BGR of the person; share : (H, W) uint8 of the person in each pixel
    backdrop : (H, W, 3) uint8 BGR
    """

    colours: NDArray[np.uint8]
    alpha: NDArray[np.uint8]
    backdrop: NDArray[np.uint8]


def estimate_matte(pixels: NDArray[np.uint8], person: NDArray[np.uint8], /) -> Matte:
    """Cut the person out of a picture (H, W, 3) uint8 BGR. person : (H, W) uint8, as `person_share`."""
    backdrop = inpaint_background(pixels, person)
    outside, inside = sure_background(person), _surely(person)
    if not outside.any() or not inside.any():
        return Matte(pixels, person, backdrop)
    picture, behind = pixels.astype(np.float32), backdrop.astype(np.float32)
    own = push_pull_fill(picture, inside)
    prior = person.astype(np.float32) / np.float32(255)
    share = _share(picture, own, behind, prior=prior, unevenness=_unevenness(picture, outside))
    share = np.asarray(cv2.GaussianBlur(np.where(inside, 1, share), (0, 0), 0.7), np.float32) * _fade(outside)
    layer = share[..., None]
    colours = (picture - (1 - layer) * behind) / np.maximum(layer, MIN_RELIABLE_ALPHA / 8)
    told = np.clip(layer / MIN_RELIABLE_ALPHA, 0, 1)  # the less of him there is, the less his colour is known
    colours = own + told * (np.clip(colours, 0, 255) - own)
    return Matte(_to_bytes(colours), _to_bytes(share * 255), backdrop)


def _share(picture: Image, foreground: Image, behind: Image, *, prior: Image, unevenness: Image) -> Image:
    """Return (H, W), 0 to 1: how far each colour is on the way from the background's to the person's."""
    way, seen = foreground - behind, picture - behind
    along, length = np.sum(seen * way, axis=2), np.sum(way * way, axis=2)
    reached = np.clip(along / np.maximum(length, 1), 0, 1)[..., None]
    foreign = np.sum(np.square(seen - reached * way), axis=2)
    trust = PRIOR_WEIGHT + VARIANCE_WEIGHT * unevenness + RESIDUAL_WEIGHT * foreign
    return np.asarray(np.clip((along + trust * prior) / (length + trust), 0, 1), np.float32)


def _unevenness(picture: Image, outside: NDArray[np.bool_]) -> Image:
    """Return (H, W): how much the background's colours vary about each place, squared grey levels."""
    sigma = max(0.5, AROUND * len(picture))
    weight = cv2.GaussianBlur(outside.astype(np.float32), (0, 0), sigma)
    known = picture * outside[..., None]
    mean = cv2.GaussianBlur(known, (0, 0), sigma) / np.maximum(weight, 1e-3)[..., None]
    square = cv2.GaussianBlur(np.sum(known * picture, axis=2), (0, 0), sigma) / np.maximum(weight, 1e-3)
    spread = np.maximum(square - np.sum(mean * mean, axis=2), 0).astype(np.float32)
    enough = weight > min(0.3, float(weight.max()) / 2)
    return push_pull_fill(spread[..., None], np.asarray(enough))[..., 0]


def _surely(person: NDArray[np.uint8]) -> NDArray[np.bool_]:
    reach = max(1, round(SURE_FOREGROUND * len(person)))
    around = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * reach + 1, 2 * reach + 1))
    return np.asarray(cv2.erode((person > 127).astype(np.uint8), around) > 0)


def _fade(outside: NDArray[np.bool_]) -> Image:
    """Return (H, W): 1, and 0 where there is surely no person."""
    distance = cv2.distanceTransform((~outside).astype(np.uint8), cv2.DIST_L2, 3)
    return np.asarray(np.clip(distance / max(FADE * UNCERTAIN_BAND * len(outside), 1), 0, 1), np.float32)


def _to_bytes(values: NDArray[np.floating]) -> NDArray[np.uint8]:
    return np.asarray(np.clip(np.rint(values), 0, 255), dtype=np.uint8)
