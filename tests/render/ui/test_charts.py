import numpy as np
import pytest

from conf.render.ui.charts import SIZE, Bar, bar_chart

pytestmark = pytest.mark.usefixtures("gl")


def blue(pixels: np.ndarray) -> np.ndarray:
    """Return (H, W) bool: where the pixels are blue."""
    return np.asarray(pixels[..., 0].astype(int) - pixels[..., 2] > 100)


def test_the_length_of_a_bar_is_logarithmic() -> None:
    values = [100_000.0, 1000.0, 10.0]
    mask = blue(bar_chart("bytes", [(f"{v}", v, f"{v} B") for v in values]))
    assert mask.shape == SIZE[::-1]
    rows = np.flatnonzero(mask.sum(axis=1) > 40)
    starts = np.split(rows, np.flatnonzero(np.diff(rows) > 5) + 1)
    lengths = [float(np.median(mask[start].sum(axis=1))) for start in starts]
    assert len(lengths) == 3
    assert lengths[0] - lengths[1] == pytest.approx(lengths[1] - lengths[2], rel=0.03)


@pytest.mark.parametrize("bars", [[], [("a", 0.0, "0")]])
def test_empty_or_non_positive_bars_are_refused(bars: list[Bar]) -> None:
    with pytest.raises(ValueError, match="bars must not be empty, and their values must be positive"):
        bar_chart("t", bars)
