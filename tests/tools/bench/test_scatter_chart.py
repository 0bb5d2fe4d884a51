import numpy as np
import pytest

from conf.render.ui.charts import SIZE
from tools.bench.scatter_chart import ScatterPoint, scatter_chart


@pytest.mark.slow
def test_points_are_drawn_at_their_coordinates(gl: None) -> None:
    points = [ScatterPoint("left and low", 1.0, 1.0), ScatterPoint("right and high", 100.0, 9.0)]
    pixels = scatter_chart("loss", ("kbit/s", "error"), points)
    ys, xs = np.nonzero(pixels[..., 0].astype(int) - pixels[..., 2] > 100)
    left, right = xs < SIZE[0] / 2, xs >= SIZE[0] / 2
    assert left.any() and right.any()
    assert ys[left].mean() > ys[right].mean() + 100


def test_empty_points_are_refused() -> None:
    with pytest.raises(ValueError, match="points must not be empty, and their x must be positive"):
        scatter_chart("t", ("x", "y"), [])
