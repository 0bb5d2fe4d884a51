import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.animator.gui.layout import SCALE, Layout


@pytest.mark.slow
@given(st.integers(320, 4000), st.integers(240, 3000), st.sampled_from([1.0, 2.0]))
def test_columns_cover_the_window_and_the_viewport_lies_inside(width: int, height: int, ratio: float) -> None:
    layout = Layout.of((width, height), SCALE.scale((width, height), ratio))
    assert layout.left.width + layout.face.width + layout.right.width == width
    assert layout.face.width == layout.timeline.width and layout.face.width >= width / 4
    x, y, w, h = layout.face_viewport(height)
    assert x >= 0 and y >= 0 and w > 0 and h > 0 and x + w <= width and y + h <= height
