import cv2
import numpy as np
from numpy.typing import NDArray

from conf.sender.portrait.skin_texture import SKIN_PATCHES, skin_texture_residual
from tests.sender.portrait.test_occlusion import shaded
from tests.support.portrait_subjects import landmarks


def face() -> NDArray[np.float32]:
    """Return landmarks whose areas of skin lie apart, as on a face."""
    found = landmarks()
    low, high = found[:, :2].min(axis=0), found[:, :2].max(axis=0)
    for number, area in enumerate(SKIN_PATCHES):
        middle = low + (high - low) * ((number + 0.5) / len(SKIN_PATCHES), 0.7)
        angles = np.linspace(0, 2 * np.pi, len(area), endpoint=False)
        found[list(area), :2] = middle + 9 * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    return found


def test_a_slope_of_light_is_smooth_and_fingers_are_not() -> None:
    height, width = shaded().shape[:2]
    slope = np.linspace(60, 220, width)[None, :, None] * np.ones((height, 1, 3))
    bare = slope.astype(np.uint8)
    points = face()
    x, y = points[list(SKIN_PATCHES[2]), :2].mean(axis=0).astype(int).tolist()
    hand = bare.copy()
    cv2.line(hand, (x, y - 30), (x, y + 30), (250, 250, 250), 5)
    assert skin_texture_residual(bare, points) < 0.02 < 0.15 < skin_texture_residual(hand, points)


def test_a_face_beyond_the_border_or_of_a_few_pixels_is_no_error() -> None:
    pixels = shaded()
    assert np.isfinite(skin_texture_residual(pixels, face() - 500))
    assert np.isfinite(skin_texture_residual(pixels, np.asarray(face() * 0.01, np.float32)))
