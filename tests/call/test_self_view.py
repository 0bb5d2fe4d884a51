import numpy as np
import pytest

from conf.call.self_view import HEIGHT, SelfView
from conf.sender.capture.frame import Frame


def frame(height: int, width: int) -> Frame:
    """Return a frame whose left half is white."""
    pixels = np.zeros((height, width, 3), np.uint8)
    pixels[:, : width // 2] = 255
    return Frame(pixels, 1.0)


@pytest.mark.parametrize("size", [(480, 640), (1080, 1920), (120, 160)])
def test_the_image_is_mirrored_and_small(size: tuple[int, int]) -> None:
    view = SelfView()
    assert view.image is None
    view.show(frame(*size), None)
    image = view.image
    assert image is not None and image.flags.c_contiguous
    assert image.shape[0] == min(HEIGHT, size[0])
    assert image.shape[1] / image.shape[0] == pytest.approx(size[1] / size[0], rel=0.01)
    middle = image.shape[1] // 2
    assert image[:, : middle - 2, :3].max() == 0 and image[:, middle + 2 :].min() == 255 == image[..., 3].min()


def test_an_image_that_was_shown_is_not_changed_by_the_next() -> None:
    view = SelfView()
    view.show(frame(20, 20), None)
    first = view.image
    assert first is not None
    before = first.copy()
    view.show(Frame(np.full((20, 20, 3), 9, np.uint8), 2.0), None)
    np.testing.assert_array_equal(first, before)
    view.clear()
    assert view.image is None
