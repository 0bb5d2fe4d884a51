import numpy as np
from numpy.typing import NDArray

from conf.receiver.portrait.inpainting import person_mask
from conf.receiver.portrait.matting import estimate_matte

WALL, COAT = np.array((200.0, 100.0, 50.0)), np.array((20.0, 30.0, 160.0))
OUTLINE = np.array([(0.3, 1.0), (0.3, 0.3), (0.7, 0.3), (0.7, 1.0)])
SIZE = (160, 120)


def picture(half_width: float) -> NDArray[np.uint8]:
    """Return (120, 160, 3): a coat before a wall, its upright edges blurred, so far from the middle in px."""
    at = np.abs(np.arange(SIZE[0]) - 79.5)
    share = np.clip((half_width - at) / 4 + 0.5, 0, 1)[None, :, None] * (np.arange(SIZE[1]) >= 36)[:, None, None]
    return np.asarray(np.rint(share * COAT + (1 - share) * WALL), dtype=np.uint8)


def test_laid_over_its_background_the_person_gives_the_picture_again() -> None:
    pixels = picture(33.0)
    cutout = estimate_matte(pixels, person_mask(OUTLINE, SIZE))
    share = cutout.alpha[..., None] / 255
    again = share * cutout.colours + (1 - share) * cutout.backdrop
    assert np.abs(again - pixels).mean() < 0.5
    assert np.abs(again - pixels)[60:].max() < 12


def test_no_rim_of_the_old_background_is_carried_along() -> None:
    for half_width in (32.0, 33.0, 34.0):  # the outline says 32: it may be off
        cutout = estimate_matte(picture(half_width), person_mask(OUTLINE, SIZE))
        seen = cutout.alpha[70] > 127
        assert abs(seen.sum() / 2 - half_width) <= 1
        assert np.abs(cutout.colours[70][seen] - COAT).max() < 45


def test_without_an_outline_everything_is_person() -> None:
    pixels = picture(32.0)
    cutout = estimate_matte(pixels, person_mask(OUTLINE[:0], SIZE))
    assert cutout.colours is pixels and cutout.backdrop is pixels and cutout.alpha.min() == 255


def test_the_smallest_pictures_can_be_cut() -> None:
    for width, height in ((1, 1), (2, 5), (9, 8)):
        pixels = np.zeros((height, width, 3), np.uint8)
        cutout = estimate_matte(pixels, person_mask(OUTLINE, (width, height)))
        assert cutout.alpha.shape == (height, width)
