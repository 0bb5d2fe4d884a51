from hypothesis import given
from hypothesis import strategies as st

from conf.start.gui.layout import MIN_SIZE, SCALE, Layout


@given(st.integers(64, 4000), st.integers(64, 3000), st.sampled_from([1.0, 1.5, 2.0]))
def test_the_rectangles_cover_the_window(width: int, height: int, ratio: float) -> None:
    scale = SCALE.scale((width, height), ratio)
    assert scale >= ratio
    layout = Layout.of((width, height), scale)
    assert layout.left.width + layout.right.width == width == layout.page.width
    assert layout.left.y == layout.right.y == layout.header.height
    if layout.page.height > 1:
        assert layout.header.height + layout.page.height + layout.footer.height == height


def test_the_smallest_window_has_scale_1() -> None:
    assert SCALE.scale(MIN_SIZE, 1.0) == 1.0
    assert SCALE.scale((2 * MIN_SIZE[0], 2 * MIN_SIZE[1]), 2.0) == 2.0
