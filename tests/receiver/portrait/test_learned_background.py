import numpy as np

from conf.receiver.portrait.inpainting import person_mask
from conf.receiver.portrait.learned_background import add_background

SIZE = (320, 240)
OUTLINE = np.array([(0.4, 1.0), (0.4, 0.3), (0.6, 0.3), (0.6, 1.0)])


def test_the_image_is_shown_behind_the_person_and_nowhere_else() -> None:
    person = person_mask(OUTLINE, SIZE)
    photo = np.full((SIZE[1], SIZE[0], 3), 200, np.uint8)
    photo[person > 127] = 40
    backdrop = np.full_like(photo, 200)
    image = np.full((30, 40, 3), (10, 90, 30), np.uint8)
    result = add_background(backdrop, photo, person, image, (0.3, 0.25, 0.7, 0.75))
    np.testing.assert_allclose(result[120, 150:170], np.broadcast_to((10, 90, 30), (20, 3)), atol=2)
    np.testing.assert_array_equal(result[:, :90], backdrop[:, :90])
    np.testing.assert_array_equal(result[120, 100:110], backdrop[120, 100:110])  # seen in the photo
    np.testing.assert_array_equal(result[:50], backdrop[:50])
    np.testing.assert_array_equal(result[200:], backdrop[200:])


def test_the_border_of_the_image_is_soft() -> None:
    person = person_mask(OUTLINE, SIZE)
    photo = np.full((SIZE[1], SIZE[0], 3), 200, np.uint8)
    result = add_background(photo, photo, person, np.zeros((30, 40, 3), np.uint8), (0.3, 0.25, 0.7, 0.75))
    assert np.abs(np.diff(result[:, 160, 0].astype(int))).max() < 80
