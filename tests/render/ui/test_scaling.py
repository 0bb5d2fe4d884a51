import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.render.ui.scaling import ScaleRule

RULE = ScaleRule((640, 480), exponent=0.5, limits=(0.8, 2.5))


@given(st.integers(64, 4000), st.integers(64, 3000), st.sampled_from([1.0, 1.5, 2.0]))
def test_the_scale_grows_with_the_window_within_its_limits(width: int, height: int, ratio: float) -> None:
    scale = RULE.scale((width, height), ratio)
    assert 0.8 * ratio <= scale <= 2.5 * ratio
    assert RULE.scale((2 * width, 2 * height), ratio) >= scale
    assert RULE.scale((round(width * ratio), round(height * ratio)), ratio) == pytest.approx(
        RULE.scale((width, height), 1.0) * ratio, rel=0.02
    )


def test_the_smaller_side_counts_to_the_power_of_the_exponent() -> None:
    assert RULE.scale((640, 480), 1.0) == 1.0
    assert RULE.scale((4 * 640, 4 * 480), 1.0) == RULE.scale((9000, 4 * 480), 1.0) == 2.0
