"""Charts as images, drawn offscreen with ImPlot."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from imgui_bundle import imgui, implot
from numpy.typing import NDArray

from conf.render.ui.imgui_overlay import ACCENT, ImGuiOverlay, panel
from conf.render.window.offscreen import OffscreenWindow

SIZE = (900, 460)
FLAGS = implot.Flags_.no_legend | implot.Flags_.no_mouse_text | implot.Flags_.no_inputs
VALUE_LABEL_FACTOR = 20.0  # the axis ends at this multiple of the largest value, to leave room for the bars' labels


@dataclass(frozen=True)
class Bar:
    """One bar: name to its left, length, text to its right."""

    name: str
    value: float
    text: str


def bar_chart(title: str, bars: list[Bar], *, size: tuple[int, int] = SIZE) -> NDArray[np.uint8]:
    """Return (H, W, 3) uint8 BGR: horizontal bars, the first on top, lengths on a logarithmic scale.

    Raises ValueError if there are no bars or a value is not positive, GraphicsError without OpenGL.
    """
    if not bars or not all(bar.value > 0 for bar in bars):
        raise ValueError("bars must not be empty, and their values must be positive")
    return render_plot(size, lambda plot: _draw_bars(title, bars, plot))


def render_plot(size: tuple[int, int], draw: Callable[[tuple[float, float]], None]) -> NDArray[np.uint8]:
    """Return the image of what `draw` draws with ImPlot; it is passed the width and height of the plot."""
    plot = (size[0] - 20.0, size[1] - 16.0)
    with OffscreenWindow(*size) as window, ImGuiOverlay(window.ctx) as overlay:
        for _ in range(2):  # ImPlot lays its axes out in the first frame
            window.begin()
            with overlay.frame(window), panel("chart", (0, 0), (0.0, 0.0), plot):
                draw(plot)
            window.end()
        return window.read()


def _draw_bars(title: str, bars: list[Bar], size: tuple[float, float]) -> None:
    rows = np.arange(len(bars), dtype=np.float64)[::-1].copy()
    values = np.array([bar.value for bar in bars])
    if not implot.begin_plot(title, imgui.ImVec2(*size), FLAGS):
        return
    bare = implot.AxisFlags_.no_grid_lines | implot.AxisFlags_.no_tick_marks
    implot.setup_axes("", "", implot.AxisFlags_.no_decorations, bare)
    implot.setup_axis_scale(implot.ImAxis_.x1, implot.Scale_.log10)
    low, high = values.min() / 3, values.max() * VALUE_LABEL_FACTOR
    implot.setup_axes_limits(low, high, -0.6, len(bars) - 0.4, imgui.Cond_.always)
    implot.setup_axis_ticks(implot.ImAxis_.y1, rows.tolist(), [bar.name for bar in bars], False)
    colour = implot.Spec(fill_color=imgui.ImVec4(*ACCENT), flags=implot.BarsFlags_.horizontal)
    implot.plot_bars("bars", values, rows, 0.6, spec=colour)
    for bar, row in zip(bars, rows, strict=True):
        half = imgui.calc_text_size(bar.text).x / 2
        implot.plot_text(bar.text, bar.value, float(row), imgui.ImVec2(half + 8, 0))
    implot.end_plot()
