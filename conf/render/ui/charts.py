"""Charts as images, drawn offscreen with ImPlot."""

from collections.abc import Callable

import numpy as np
from imgui_bundle import imgui, implot
from numpy.typing import NDArray

from conf.render.ui.imgui_overlay import ACCENT, ImGuiOverlay, panel
from conf.render.window.offscreen import OffscreenWindow

SIZE = (900, 460)
FLAGS = implot.Flags_.no_legend | implot.Flags_.no_mouse_text | implot.Flags_.no_inputs
VALUE_LABEL_FACTOR = 20.0  # the axis ends at this multiple of the largest value, to leave room for the bars' labels


Bar = tuple[str, float, str]  # name to its left, length, text to its right


def bar_chart(title: str, bars: list[Bar], *, size: tuple[int, int] = SIZE) -> NDArray[np.uint8]:
    """Return (H, W, 3) uint8 BGR: horizontal bars, the first on top, lengths on a logarithmic scale.

    Raises ValueError if there are no bars or a value is not positive, GraphicsError without OpenGL.
    """
    if not bars or not all(value > 0 for _, value, _ in bars):
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
    names, values, texts = zip(*bars, strict=True)
    if not implot.begin_plot(title, imgui.ImVec2(*size), FLAGS):
        return
    bare = implot.AxisFlags_.no_grid_lines | implot.AxisFlags_.no_tick_marks
    implot.setup_axes("", "", implot.AxisFlags_.no_decorations, bare)
    implot.setup_axis_scale(implot.ImAxis_.x1, implot.Scale_.log10)
    low, high = min(values) / 3, max(values) * VALUE_LABEL_FACTOR
    implot.setup_axes_limits(low, high, -0.6, len(bars) - 0.4, imgui.Cond_.always)
    implot.setup_axis_ticks(implot.ImAxis_.y1, rows.tolist(), list(names), False)
    colour = implot.Spec(fill_color=imgui.ImVec4(*ACCENT), flags=implot.BarsFlags_.horizontal)
    implot.plot_bars("bars", np.array(values), rows, 0.6, spec=colour)
    for value, text, row in zip(values, texts, rows.tolist(), strict=True):
        half = imgui.calc_text_size(text).x / 2
        implot.plot_text(text, value, row, imgui.ImVec2(half + 8, 0))
    implot.end_plot()
