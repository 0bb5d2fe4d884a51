"""Bar and scatter charts with a logarithmic axis as images, drawn offscreen with ImPlot."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from imgui_bundle import imgui, implot
from numpy.typing import NDArray

from conf.render.ui.imgui_overlay import ACCENT, ImGuiOverlay, panel
from conf.render.window.offscreen import OffscreenWindow

SIZE = (900, 460)
FLAGS = implot.Flags_.no_legend | implot.Flags_.no_mouse_text | implot.Flags_.no_inputs
HIGHLIGHT = (0.35, 0.90, 0.50, 1.0)
Box = tuple[float, float, float, float]  # left, top, right, bottom, pixels
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
    return _render(size, lambda plot: _draw_bars(title, bars, plot))


def _render(size: tuple[int, int], draw: Callable[[tuple[float, float]], None]) -> NDArray[np.uint8]:
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


@dataclass(frozen=True)
class ScatterPoint:
    """One point of a scatter chart: name, coordinates, whether it is one of ours and highlighted."""

    name: str
    x: float
    y: float
    ours: bool = False


def scatter_chart(
    title: str, axes: tuple[str, str], points: list[ScatterPoint], *, size: tuple[int, int] = SIZE
) -> NDArray[np.uint8]:
    """Return (H, W, 3) uint8 BGR: named points, x on a logarithmic scale.

    axes : labels of x and y
    Raises ValueError if there are no points or an x is not positive, GraphicsError without OpenGL.
    """
    if not points or not all(point.x > 0 for point in points):
        raise ValueError("points must not be empty, and their x must be positive")
    return _render(size, lambda plot: _draw_scatter(title, axes, points, plot))


def _draw_scatter(title: str, axes: tuple[str, str], points: list[ScatterPoint], size: tuple[float, float]) -> None:
    if not implot.begin_plot(title, imgui.ImVec2(*size), FLAGS):
        return
    implot.setup_axes(*axes)
    implot.setup_axis_scale(implot.ImAxis_.x1, implot.Scale_.log10)
    x, y = np.array([point.x for point in points]), np.array([point.y for point in points])
    implot.setup_axes_limits(x.min() / 2, x.max() * 4, -0.06 * y.max(), y.max() * 1.15, imgui.Cond_.always)
    occupied: list[Box] = []
    for point in sorted(points, key=lambda point: -point.y):
        colour = imgui.ImVec4(*(HIGHLIGHT if point.ours else ACCENT))
        spec = implot.Spec(marker=implot.Marker_.circle, marker_size=5.0, marker_fill_color=colour)
        implot.plot_scatter(point.name, np.array([point.x], float), np.array([point.y], float), spec=spec)
        implot.plot_text(point.name, point.x, point.y, imgui.ImVec2(*_label_offset(point, occupied)))
    implot.end_plot()


def _label_offset(point: ScatterPoint, occupied: list[Box]) -> tuple[float, float]:
    """Return the offset of a name from its point, pixels, that avoids the occupied boxes, and add its box to them.

    Without a free position the name is to the upper right.
    """
    centre, text = implot.plot_to_pixels(point.x, point.y), imgui.calc_text_size(point.name)
    width, height = text.x / 2, text.y / 2
    offsets = [(side * (width + 9), rise) for rise in (-8, 0, 8) for side in (1, -1)]
    boxes = [
        (centre.x + x - width, centre.y + y - height, centre.x + x + width, centre.y + y + height) for x, y in offsets
    ]
    free = [i for i, box in enumerate(boxes) if not any(_overlap(box, other) for other in occupied)]
    chosen = free[0] if free else 0
    occupied += [boxes[chosen], (centre.x - 5, centre.y - 5, centre.x + 5, centre.y + 5)]
    return offsets[chosen]


def _overlap(a: Box, b: Box) -> bool:
    return a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]
