"""Charts as images, drawn offscreen with ImPlot."""

from collections.abc import Callable
from math import ceil, floor, log10

import numpy as np
from imgui_bundle import imgui, implot
from numpy.typing import NDArray

from conf.render.ui.imgui_overlay import ACCENT, ImGuiOverlay, panel
from conf.render.window.offscreen import OffscreenWindow

SIZE = (900, 460)
FLAGS = implot.Flags_.no_legend | implot.Flags_.no_mouse_text | implot.Flags_.no_inputs
LABEL_GAP = 8.0  # px, on both sides of the text beside a bar
MAX_LABEL_WIDTH = 0.8  # of the axis; a wider label is clipped, as its bar would vanish

Bar = tuple[str, float, str]  # name to its left, length, text to its right


def bar_chart(title: str, bars: list[Bar], *, size: tuple[int, int] = SIZE) -> NDArray[np.uint8]:
    """Return (H, W, 3) uint8 BGR: horizontal bars, the first on top, lengths on a logarithmic scale.

    Raises ValueError if there are no bars or a value is not positive, GraphicsError without OpenGL.
    """
    if not bars or not all(value > 0 for _, value, _ in bars):
        raise ValueError("bars must not be empty, and their values must be positive")
    plot_widths = list[float]()
    return render_plot(size, lambda plot: _draw_bars(title, bars, plot, plot_widths))


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


def _draw_bars(title: str, bars: list[Bar], size: tuple[float, float], plot_widths: list[float]) -> None:
    """Draw the bars; plot_widths, from the frame before, is what the axis leaves to them in px."""
    rows = np.arange(len(bars), dtype=np.float64)[::-1].copy()
    names, values, texts = zip(*bars, strict=True)
    if not implot.begin_plot("##bars", imgui.ImVec2(*size), FLAGS):
        return
    bare = implot.AxisFlags_.no_grid_lines | implot.AxisFlags_.no_tick_marks
    implot.setup_axes(f"{title}, logarithmic scale", "", implot.AxisFlags_.none, bare)
    implot.setup_axis_scale(implot.ImAxis_.x1, implot.Scale_.log10)
    plot_width = plot_widths[-1] if plot_widths else size[0]
    low = min(values) / 3
    widths = [(imgui.calc_text_size(text).x + 2 * LABEL_GAP) / plot_width for text in texts]
    high = axis_end(low, list(values), widths)
    implot.setup_axes_limits(low, high, -0.6, len(bars) - 0.4, imgui.Cond_.always)
    decades = {10.0**power: f"{10.0**power:,.12g}" for power in range(ceil(log10(low)), floor(log10(high)) + 1)}
    to_edge = {decade: log10(high / decade) / log10(high / low) * plot_width for decade in decades}  # px
    ticks = {d: text for d, text in decades.items() if imgui.calc_text_size(text).x / 2 < to_edge[d]}
    implot.setup_axis_ticks(implot.ImAxis_.x1, list(ticks), list(ticks.values()), False)
    implot.setup_axis_ticks(implot.ImAxis_.y1, rows.tolist(), list(names), False)
    colour = implot.Spec(fill_color=imgui.ImVec4(*ACCENT), flags=implot.BarsFlags_.horizontal)
    implot.plot_bars("bars", np.array(values), rows, 0.6, spec=colour)
    for value, text, row in zip(values, texts, rows.tolist(), strict=True):
        half = imgui.calc_text_size(text).x / 2
        implot.plot_text(text, value, row, imgui.ImVec2(half + LABEL_GAP, 0))
    plot_widths.append(float(implot.get_plot_size().x))
    implot.end_plot()


def axis_end(low: float, values: list[float], label_widths: list[float], /) -> float:
    """Return where a logarithmic axis from `low` must end so that each value's label fits to its right.

    label_widths : with the gaps, as fractions of the axis
    """
    ends = [
        log10(value / low) / (1 - min(width, MAX_LABEL_WIDTH))
        for value, width in zip(values, label_widths, strict=True)
    ]
    return float(low * 10 ** max(ends))
