import numpy as np
from numpy.typing import NDArray

from conf.receiver.portrait.inpainting import inpaint_background, person_mask, sure_background

SQUARE = np.array([(0.4, 0.4), (0.6, 0.4), (0.6, 0.6), (0.4, 0.6)])


def fill(pixels: NDArray[np.uint8], outline: NDArray[np.float64]) -> NDArray[np.uint8]:
    height, width = pixels.shape[:2]
    return inpaint_background(pixels, sure_background(pixels, person_mask(outline, (width, height))))


def test_strands_of_hair_beyond_the_outline_are_no_background() -> None:
    pixels = np.full((240, 200, 3), (200, 180, 160), np.uint8)
    pixels[96:144, 80:120] = pixels[88:96:3, 80:120] = (20, 30, 40)
    known = sure_background(pixels, person_mask(SQUARE, (200, 240)))
    assert not known[88:96:3, 90:110].any() and known[84, 100], "hair, and the wall beyond"
    assert known[96:144, 70:73].all() and not known[100:140, 78:82].any(), "the wall beside, and the outline"


def test_the_mask_is_255_inside_the_outline() -> None:
    mask = person_mask(SQUARE, (100, 80))
    assert mask.shape == (80, 100)
    assert mask[40, 50] == 255 and mask[5, 5] == 0
    assert person_mask(SQUARE[:2], (10, 10)).min() == 255


def test_the_person_is_replaced_by_the_background_and_the_rest_is_unchanged() -> None:
    pixels = np.full((80, 100, 3), (200, 100, 50), np.uint8)
    pixels[30:50, 38:62] = (0, 0, 255)
    filled = fill(pixels, SQUARE)
    assert np.abs(filled[40, 50].astype(int) - (200, 100, 50)).max() < 12
    np.testing.assert_array_equal(filled[:20], pixels[:20])


def test_an_image_without_background_is_unchanged() -> None:
    pixels = np.zeros((8, 8, 3), np.uint8)
    known = sure_background(pixels, np.full((8, 8), 255, np.uint8))
    assert not known.any() and inpaint_background(pixels, known) is pixels


def test_stripes_continue_behind_the_person() -> None:
    pixels = np.full((80, 200, 3), 100, np.uint8)
    pixels[::8] = pixels[1::8] = 180
    stripes = pixels.copy()
    pixels[20:70, 80:120] = (0, 0, 255)
    outline = np.array([(0.4, 0.25), (0.6, 0.25), (0.6, 0.87), (0.4, 0.87)])
    filled = fill(pixels, outline)
    assert np.abs(filled.astype(int) - stripes)[24:66, 92:108].mean() < 15


def test_a_person_as_wide_as_the_image_hides_a_smooth_background() -> None:
    pixels = np.random.default_rng(1).integers(0, 256, (80, 100, 3)).astype(np.uint8)
    outline = np.array([(0.0, 0.5), (1.0, 0.5), (1.0, 1.0), (0.0, 1.0)])
    filled = fill(pixels, outline)
    assert filled[60:].astype(float).std() < 15


def test_an_object_beside_the_person_appears_once() -> None:
    pixels = np.full((80, 200, 3), 120, np.uint8)
    pixels[30:60, 10:60:4] = (0, 0, 255)  # a picture on the wall, left of the person alone
    pixels[20:70, 80:120] = 0
    outline = np.array([(0.4, 0.25), (0.6, 0.25), (0.6, 0.87), (0.4, 0.87)])
    filled = fill(pixels, outline)
    assert np.abs(filled.astype(int) - 120)[30:60, 88:112].max() < 15
