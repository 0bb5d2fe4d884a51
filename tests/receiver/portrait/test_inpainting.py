import numpy as np

from conf.face.portrait.photo_mesh import BORDER_EXTENSION
from conf.receiver.portrait.inpainting import extend_border, inpaint_background, person_mask

SQUARE = np.array([(0.4, 0.4), (0.6, 0.4), (0.6, 0.6), (0.4, 0.6)])


def test_the_mask_is_255_inside_the_outline() -> None:
    mask = person_mask(SQUARE, (100, 80))
    assert mask.shape == (80, 100)
    assert mask[40, 50] == 255 and mask[5, 5] == 0
    assert person_mask(SQUARE[:2], (10, 10)).min() == 255


def test_the_person_is_replaced_by_the_background_and_the_rest_is_unchanged() -> None:
    pixels = np.full((80, 100, 3), (200, 100, 50), np.uint8)
    pixels[30:50, 38:62] = (0, 0, 255)
    filled = inpaint_background(pixels, person_mask(SQUARE, (100, 80)))
    assert np.abs(filled[40, 50].astype(int) - (200, 100, 50)).max() < 12
    np.testing.assert_array_equal(filled[:20], pixels[:20])


def test_an_image_without_background_is_unchanged() -> None:
    pixels = np.zeros((8, 8, 3), np.uint8)
    assert inpaint_background(pixels, np.full((8, 8), 255, np.uint8)) is pixels


def test_the_margin_continues_the_colours_and_is_smoother_farther_out() -> None:
    colours = np.zeros((80, 120, 3), np.uint8)
    colours[:, ::8] = 200
    extended, alpha, margin = extend_border(colours, np.full((80, 120), 255, np.uint8))
    x, y = np.rint(margin * (120, 80)).astype(int)
    assert x == y == np.ceil(BORDER_EXTENSION * 80) and extended.shape == (80 + 2 * y, 120 + 2 * x, 3)
    np.testing.assert_array_equal(extended[y:-y, x:-x], colours)
    near, far = extended[y - 1, x:-x, 0].astype(float), extended[2, x:-x, 0].astype(float)
    assert near.std() < colours[0, :, 0].std() and far.std() < 0.2 * near.std() + 5
    assert 10 < far.mean() < 60 and (alpha == 255).all()


def test_alpha_continues_only_next_to_the_person() -> None:
    alpha = np.zeros((80, 120), np.uint8)
    alpha[:, :30] = 255
    _, extended, margin = extend_border(np.zeros((80, 120, 3), np.uint8), alpha)
    y = round(float(margin[1]) * 80)
    assert extended[y - 2, y + 5] > 200 and extended[y - 2, -y - 20] < 20
