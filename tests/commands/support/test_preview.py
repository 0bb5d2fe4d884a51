import numpy as np

from conf.commands.support.preview import DOT, MUTED, rgba, with_points, with_text
from conf.face.control_points import CONTROL_POINT_LANDMARKS
from conf.sender.tracking.tracker import TrackedFace


def test_points_are_drawn_on_a_copy_of_the_frame() -> None:
    pixels = np.zeros((240, 320, 3), np.uint8)
    landmarks = np.zeros((478, 3), np.float32)
    landmarks[CONTROL_POINT_LANDMARKS, 0] = 20 + 5 * np.arange(50)
    landmarks[CONTROL_POINT_LANDMARKS, 1] = 100
    image = with_points(pixels, TrackedFace(landmarks, np.zeros(52, np.float32), 1.0))
    assert all(tuple(image[100, 20 + 5 * i]) == DOT for i in range(50))
    assert not pixels.any() and not image[:90].any()
    assert not with_points(pixels, None).any()


def test_a_text_is_drawn_in_the_lower_left_corner_of_a_copy() -> None:
    pixels = np.zeros((240, 320, 3), np.uint8)
    image = with_text(pixels, MUTED)
    rows, columns = np.nonzero(image.any(axis=2))
    assert not pixels.any() and rows.min() > 180 and 0 < columns.min() and columns.max() < 160


def test_rgba_has_the_bottom_row_first() -> None:
    pixels = np.zeros((2, 1, 3), np.uint8)
    pixels[0, 0] = (1, 2, 3)
    assert rgba(pixels).tolist() == [[[0, 0, 0, 255]], [[3, 2, 1, 255]]]
