import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.render.ui.rectangle import Rect

RECT = Rect(100, 20, 700, 500)


@given(st.floats(-1, 1), st.floats(-1, 1))
def test_pixels_and_normalised_coordinates_are_inverse(x: float, y: float) -> None:
    (pixel,) = RECT.to_pixels(np.array([[x, y, 0.0]]), np.eye(4))
    assert RECT.to_ndc(*pixel) == pytest.approx((x, y), abs=1e-9)


def test_a_rectangle_contains_its_upper_left_corner_only() -> None:
    assert RECT.contains(100, 20) and RECT.contains(799, 519)
    assert not RECT.contains(800, 20) and not RECT.contains(100, 520) and not RECT.contains(99, 20)
