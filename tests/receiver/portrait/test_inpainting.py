import numpy as np

from conf.receiver.portrait.inpainting import inpaint_background, person_mask

SQUARE = np.array([(0.4, 0.4), (0.6, 0.4), (0.6, 0.6), (0.4, 0.6)])


def test_the_outline_parts_person_from_background() -> None:
    share = person_mask(SQUARE, (100, 80))
    assert share.shape == (80, 100)
    assert share[40, 50] == 255 and share[5, 5] == 0
    assert person_mask(SQUARE[:2], (10, 10)).min() == 255


def test_what_the_person_hid_is_filled_from_around_and_the_rest_is_left() -> None:
    pixels = np.full((80, 100, 3), (200, 100, 50), np.uint8)
    pixels[30:50, 38:62] = (0, 0, 255)
    filled = inpaint_background(pixels, person_mask(SQUARE, (100, 80)))
    assert np.abs(filled[40, 50].astype(int) - (200, 100, 50)).max() < 12
    np.testing.assert_array_equal(filled[:20], pixels[:20])


def test_a_picture_full_of_person_has_nothing_to_fill_from() -> None:
    pixels = np.zeros((8, 8, 3), np.uint8)
    assert inpaint_background(pixels, np.full((8, 8), 255, np.uint8)) is pixels
