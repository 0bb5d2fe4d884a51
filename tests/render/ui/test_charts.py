import numpy as np
import pytest

from conf.render.ui.charts import SIZE, Bar, ScatterPoint, bar_chart, scatter_chart

pytestmark = pytest.mark.usefixtures("gl")


def blue(pixels: np.ndarray) -> np.ndarray:
    """Return (H, W) bool: where the bars' colour is."""
    return np.asarray(pixels[..., 0].astype(int) - pixels[..., 2] > 100)


def test_each_bar_is_as_long_as_its_logarithm() -> None:
    values = [100_000.0, 1000.0, 10.0]
    mask = blue(bar_chart("bytes", [Bar(f"{v}", v, f"{v} B") for v in values]))
    assert mask.shape == SIZE[::-1]
    rows = np.flatnonzero(mask.sum(axis=1) > 40)
    starts = np.split(rows, np.flatnonzero(np.diff(rows) > 5) + 1)
    lengths = [float(np.median(mask[start].sum(axis=1))) for start in starts]
    assert len(lengths) == 3
    assert lengths[0] - lengths[1] == pytest.approx(lengths[1] - lengths[2], rel=0.03)


def test_dots_stand_where_their_numbers_say() -> None:
    dots = [ScatterPoint("left and low", 1.0, 1.0), ScatterPoint("right and high", 100.0, 9.0)]
    mask = blue(scatter_chart("loss", ("kbit/s", "error"), dots))
    ys, xs = np.nonzero(mask)
    left, right = xs < SIZE[0] / 2, xs >= SIZE[0] / 2
    assert left.any() and right.any()
    assert ys[left].mean() > ys[right].mean() + 100


@pytest.mark.parametrize("bars", [[], [Bar("a", 0.0, "0")]])
def test_bars_must_be_there_and_positive(bars: list[Bar]) -> None:
    with pytest.raises(ValueError, match="bars must be there and positive"):
        bar_chart("t", bars)


def test_dots_must_be_there_and_positive() -> None:
    with pytest.raises(ValueError, match="dots must be there, with positive x"):
        scatter_chart("t", ("x", "y"), [])
