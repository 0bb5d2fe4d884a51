"""Orientation, pixel aspect ratio and size of images."""

import math

import cv2
import numpy as np
from numpy.typing import NDArray

MAX_ASPECT = 8.0  # a pixel aspect ratio beyond this, either way, is a fault of the file


def square_pixel_size(width: int, height: int, aspect: float, /, *, max_pixels: int) -> tuple[int, int]:
    """Return the size, px, at which an image has square pixels: one side grows, or shrinks if there were too many.

    aspect : width of a pixel divided by its height
    """
    if not 1 / MAX_ASPECT <= aspect <= MAX_ASPECT:
        return width, height
    wider, higher = round(width * max(aspect, 1.0)), round(height / min(aspect, 1.0))
    if wider * higher <= max_pixels:
        return wider, higher
    return max(1, round(width * min(aspect, 1.0))), max(1, round(height / max(aspect, 1.0)))


def turn_by_matrix(pixels: NDArray[np.uint8], matrix: NDArray[np.int32] | None, /) -> NDArray[np.uint8]:
    """Return an image (H, W, 3) turned in quarter turns and mirrored as a display matrix says.

    matrix : nine numbers a b u c d v x y w; a point (p, q) of the image is shown at (a p + c q, b p + d q)
    Source: ISO/IEC 14496-12, 6.2.2.
    """
    if matrix is None or len(matrix) != 9:
        return pixels
    a, b, c, d = (int(matrix[i]) for i in (0, 1, 3, 4))
    if abs(b) + abs(c) > abs(a) + abs(d):
        pixels = pixels.transpose(1, 0, 2)
        is_mirrored, is_flipped = c < 0, b < 0
    else:
        is_mirrored, is_flipped = a < 0, d < 0
    return np.ascontiguousarray(pixels[:: -1 if is_flipped else 1, :: -1 if is_mirrored else 1])


def fit_into(pixels: NDArray[np.uint8], size: tuple[int, int], /) -> NDArray[np.uint8]:
    """Return an image at another size, (width, height) in px, its proportions kept, with black bars where needed."""
    height, width = pixels.shape[:2]
    scale = min(size[0] / width, size[1] / height)
    inner = (
        max(1, min(size[0], math.floor(width * scale + 0.5))),
        max(1, min(size[1], math.floor(height * scale + 0.5))),
    )
    interpolation = cv2.INTER_AREA if scale < 1 else cv2.INTER_LINEAR
    left, top = (size[0] - inner[0]) // 2, (size[1] - inner[1]) // 2
    result = np.zeros((size[1], size[0], 3), np.uint8)
    result[top : top + inner[1], left : left + inner[0]] = cv2.resize(pixels, inner, interpolation=interpolation)
    return result
