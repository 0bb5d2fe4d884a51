import numpy as np
import pytest
from numpy.typing import NDArray

from conf.sender.capture.geometry import fit_into, square_pixel_size, turn_by_matrix

IMAGE = np.arange(2 * 3 * 3, dtype=np.uint8).reshape(2, 3, 3)


def matrix(a: int, b: int, c: int, d: int) -> NDArray[np.int32]:
    return np.array([a, b, 0, c, d, 0, 0, 0, 1], np.int32) << 16


@pytest.mark.parametrize(
    ("aspect", "expected"),
    [
        (1.0, (720, 576)), (16 / 15, (768, 576)), (8 / 9, (720, 648)), (2.0, (1440, 576)),
        (100.0, (720, 576)), (0.001, (720, 576)), (float("nan"), (720, 576)), (0.0, (720, 576)),
    ],
)  # fmt: skip
def test_pixels_become_square(aspect: float, expected: tuple[int, int]) -> None:
    assert square_pixel_size(720, 576, aspect, max_pixels=10**6) == expected


def test_an_image_that_would_become_too_large_shrinks_on_its_other_side() -> None:
    assert square_pixel_size(1000, 1000, 4.0, max_pixels=2_000_000) == (1000, 250)
    assert square_pixel_size(1000, 1000, 0.25, max_pixels=2_000_000) == (250, 1000)
    assert square_pixel_size(1, 1, 8.0, max_pixels=1) == (1, 1)


@pytest.mark.parametrize(
    ("values", "expected"),
    [
        (None, IMAGE),
        (matrix(1, 0, 0, 1), IMAGE),
        (matrix(-1, 0, 0, 1), IMAGE[:, ::-1]),
        (matrix(1, 0, 0, -1), IMAGE[::-1]),
        (matrix(-1, 0, 0, -1), np.rot90(IMAGE, 2)),
        (matrix(0, -1, 1, 0), np.rot90(IMAGE, 1)),
        (matrix(0, 1, -1, 0), np.rot90(IMAGE, 3)),
        (matrix(0, 1, 1, 0), IMAGE.transpose(1, 0, 2)),
        (matrix(0, -1, -1, 0), np.rot90(IMAGE, 2).transpose(1, 0, 2)),
        (np.zeros(9, np.int32), IMAGE),
        (np.zeros(4, np.int32), IMAGE),
    ],
)
def test_a_display_matrix_turns_and_mirrors(values: NDArray[np.int32] | None, expected: NDArray[np.uint8]) -> None:
    turned = turn_by_matrix(IMAGE, values)
    assert np.array_equal(turned, expected) and turned.flags.c_contiguous


def test_an_image_keeps_its_proportions_at_another_size() -> None:
    tall = np.full((160, 120, 3), 200, np.uint8)
    fitted = fit_into(tall, (160, 120))
    assert fitted.shape == (120, 160, 3)
    assert (fitted[:, 35:125] == 200).all() and not fitted[:, :35].any() and not fitted[:, 125:].any()
    assert (fit_into(np.full((240, 320, 3), 9, np.uint8), (160, 120)) == 9).all()
    assert (fit_into(np.full((12, 16, 3), 9, np.uint8), (160, 120)) == 9).all()
    assert fit_into(np.full((1, 4000, 3), 9, np.uint8), (8, 8)).shape == (8, 8, 3)
