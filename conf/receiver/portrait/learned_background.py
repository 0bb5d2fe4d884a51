"""Replace the interpolated background behind a person by what the camera saw there later."""

import cv2
import numpy as np
from numpy.typing import NDArray

from conf.protocol.portrait.image_box import Box
from conf.receiver.portrait.inpainting import sure_background

FEATHER = 0.012  # image heights: standard deviation of the transition to the photo's own background


def add_background(
    backdrop: NDArray[np.uint8],
    photo: NDArray[np.uint8],
    person: NDArray[np.uint8],
    image: NDArray[np.uint8],
    box: Box,
    /,
) -> NDArray[np.uint8]:
    """Return a backdrop with an image of its background where the photo does not show it.

    backdrop, photo : (H, W, 3) uint8 BGR; person : (H, W) uint8, from person_mask; image : (h, w, 3) uint8 BGR
    box : of the image in the photo
    """
    height, width = person.shape
    left, top, right, bottom = (round(side) for side in np.array(box) * (width, height, width, height))
    right, bottom = max(right, left + 1), max(bottom, top + 1)
    enlarged = backdrop.copy()
    enlarged[top:bottom, left:right] = cv2.resize(image, (right - left, bottom - top), interpolation=cv2.INTER_LINEAR)
    behind = (~sure_background(photo, person)).astype(np.float32)
    inside = np.zeros_like(behind)
    inside[top:bottom, left:right] = 1
    sigma = max(0.5, FEATHER * height)
    side = 2 * int(np.ceil(2 * sigma)) + 1
    # Soft at the borders of the box, but for those of the photo.
    ramp = inside * cv2.GaussianBlur(cv2.erode(inside, np.ones((side, side), np.uint8)), (0, 0), sigma)
    weight = (np.maximum(cv2.GaussianBlur(behind, (0, 0), sigma), behind) * ramp)[..., None]
    return np.asarray(np.rint(backdrop + weight * (enlarged.astype(np.float32) - backdrop)), np.uint8)
