from math import log10

import numpy as np
import pytest

from conf.render.ui.charts import SIZE, Bar, axis_end, bar_chart

pytestmark = pytest.mark.usefixtures("gl")


def blue(pixels: np.ndarray) -> np.ndarray:
    """Return (H, W) bool: where the pixels are blue."""
    return np.asarray(pixels[..., 0].astype(int) - pixels[..., 2] > 100)


@pytest.mark.slow
def test_the_length_of_a_bar_is_logarithmic() -> None:
    values = [100_000.0, 1000.0, 10.0]
    mask = blue(bar_chart("bytes", [(f"{v}", v, f"{v} B") for v in values]))
    assert mask.shape == SIZE[::-1]
    rows = np.flatnonzero(mask.sum(axis=1) > 40)
    starts = np.split(rows, np.flatnonzero(np.diff(rows) > 5) + 1)
    lengths = [float(np.median(mask[start].sum(axis=1))) for start in starts]
    assert len(lengths) == 3
    assert lengths[0] - lengths[1] == pytest.approx(lengths[1] - lengths[2], rel=0.03)


@pytest.mark.slow
@pytest.mark.parametrize("text", ["7 B", "691,200 B, 82,944.0 kbit/s", "a very long label, " * 4])
def test_no_label_is_clipped(text: str) -> None:
    pixels = bar_chart("bytes", [("raw", 700_000.0, text), ("coded", 5.0, "5 B")])
    bar = np.flatnonzero(blue(pixels).sum(axis=1) > 200)  # rows of the first bar
    row = pixels[bar[0] : bar[-1], : SIZE[0] - 24].max(axis=(0, 2))  # without the plot's frame
    bright = np.flatnonzero(row > 120)
    assert bright[-1] < len(row) - 4  # px: the label ends before the frame


@pytest.mark.slow
@pytest.mark.parametrize("value", [700_000.0, 80_000.0, 999.0])
def test_no_label_of_the_axis_is_clipped(value: float) -> None:
    pixels = bar_chart("bytes", [("raw", value, "some bytes"), ("coded", 5.0, "5 B")])
    assert pixels[SIZE[1] - 60 : SIZE[1] - 20, -12:].max() < 60  # the labels end before the panel's edge


def test_the_axis_leaves_room_for_every_label() -> None:
    end = axis_end(1.0, [10.0, 1000.0], [0.75, 0.1])
    assert log10(10) / log10(end) + 0.75 == pytest.approx(1) and log10(1000) / log10(end) + 0.1 <= 1
    assert axis_end(1.0, [100.0], [2.0]) == pytest.approx(1e10)


@pytest.mark.parametrize("bars", [[], [("a", 0.0, "0")]])
def test_empty_or_non_positive_bars_are_refused(bars: list[Bar]) -> None:
    with pytest.raises(ValueError, match="bars must not be empty, and their values must be positive"):
        bar_chart("t", bars)
