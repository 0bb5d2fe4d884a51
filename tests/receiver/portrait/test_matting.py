import numpy as np
from numpy.typing import NDArray

from conf.receiver.portrait.inpainting import person_mask
from conf.receiver.portrait.matting import estimate_matte

WALL, COAT = np.array((200.0, 100.0, 50.0)), np.array((20.0, 30.0, 160.0))
OUTLINE = np.array([(0.3, 1.0), (0.3, 0.3), (0.7, 0.3), (0.7, 1.0)])
SIZE = (160, 120)


def draw_coat(half_width: float) -> NDArray[np.uint8]:
    """Return (120, 160, 3): a coat before a wall, its vertical edges blurred, half_width px from the centre."""
    distance = np.abs(np.arange(SIZE[0]) - 79.5)
    alpha = np.clip((half_width - distance) / 4 + 0.5, 0, 1)[None, :, None] * (np.arange(SIZE[1]) >= 36)[:, None, None]
    return np.asarray(np.rint(alpha * COAT + (1 - alpha) * WALL), dtype=np.uint8)


def test_the_matte_composited_over_its_backdrop_yields_the_photo() -> None:
    pixels = draw_coat(33.0)
    matte = estimate_matte(pixels, person_mask(OUTLINE, SIZE))
    alpha = matte.alpha[..., None] / 255
    composite = alpha * matte.colours + (1 - alpha) * matte.backdrop
    assert np.abs(composite - pixels).mean() < 0.5
    assert np.abs(composite - pixels)[60:].max() < 24


def test_the_person_has_no_rim_of_the_background() -> None:
    for half_width in (32.0, 33.0, 34.0):  # the outline is at 32 px, so up to 2 px off
        matte = estimate_matte(draw_coat(half_width), person_mask(OUTLINE, SIZE))
        opaque = matte.alpha[70] > 127
        assert abs(opaque.sum() / 2 - half_width) <= 1
        assert np.abs(matte.colours[70][opaque] - COAT).max() < 45


def test_without_an_outline_everything_is_person() -> None:
    pixels = draw_coat(32.0)
    matte = estimate_matte(pixels, person_mask(OUTLINE[:0], SIZE))
    assert matte.colours is pixels and matte.backdrop is pixels and matte.alpha.min() == 255


def test_tiny_images_have_a_matte() -> None:
    for width, height in ((1, 1), (2, 5), (9, 8)):
        pixels = np.zeros((height, width, 3), np.uint8)
        matte = estimate_matte(pixels, person_mask(OUTLINE, (width, height)))
        assert matte.alpha.shape == (height, width)
