"""Charts as pictures: bars and dots on a logarithmic scale, drawn offscreen with ImPlot."""

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
LABELS_ROOM = 20.0  # the value's text stands right of its bar: the axis goes on so many times further


@dataclass(frozen=True)
class Bar:
    """One bar: what stands left of it, how long it is, what stands right of it."""

    name: str
    value: float
    text: str


def bar_chart(title: str, bars: list[Bar], *, size: tuple[int, int] = SIZE) -> NDArray[np.uint8]:
    """Return (H, W, 3) uint8 BGR: horizontal bars, the first on top, lengths on a logarithmic scale.

    Raises ValueError if there are no bars or one is not positive, GraphicsError without OpenGL.
    """
    if not bars or not all(bar.value > 0 for bar in bars):
        raise ValueError("bars must be there and positive")
    return _picture(size, lambda plot: _draw_bars(title, bars, plot))


def _picture(size: tuple[int, int], draw: Callable[[tuple[float, float]], None]) -> NDArray[np.uint8]:
    """Return what `draw`, told the room it has, draws with ImPlot."""
    plot = (size[0] - 20.0, size[1] - 16.0)
    with OffscreenWindow(*size) as window:
        overlay = ImGuiOverlay(window.ctx)
        try:
            for _ in range(2):  # ImPlot lays its axes out in the first frame
                window.begin()
                with overlay.frame(window.framebuffer, size, 1.0), panel("chart", (0, 0), (0.0, 0.0), plot):
                    draw(plot)
                window.end()
            return window.read()
        finally:
            overlay.release()


def _draw_bars(title: str, bars: list[Bar], size: tuple[float, float]) -> None:
    places = np.arange(len(bars), dtype=np.float64)[::-1].copy()
    values = np.array([bar.value for bar in bars])
    if not implot.begin_plot(title, imgui.ImVec2(*size), FLAGS):
        return
    bare = implot.AxisFlags_.no_grid_lines | implot.AxisFlags_.no_tick_marks
    implot.setup_axes("", "", implot.AxisFlags_.no_decorations, bare)
    implot.setup_axis_scale(implot.ImAxis_.x1, implot.Scale_.log10)
    low, high = values.min() / 3, values.max() * LABELS_ROOM
    implot.setup_axes_limits(low, high, -0.6, len(bars) - 0.4, imgui.Cond_.always)
    implot.setup_axis_ticks(implot.ImAxis_.y1, places.tolist(), [bar.name for bar in bars], False)
    colour = implot.Spec(fill_color=imgui.ImVec4(*ACCENT), flags=implot.BarsFlags_.horizontal)
    implot.plot_bars("bars", values, places, 0.6, spec=colour)
    for bar, place in zip(bars, places, strict=True):
        half = imgui.calc_text_size(bar.text).x / 2
        implot.plot_text(bar.text, bar.value, float(place), imgui.ImVec2(half + 8, 0))
    implot.end_plot()


@dataclass(frozen=True)
class ScatterPoint:
    """One dot of a scatter: its name, where it lies, and whether it is one of ours."""

    name: str
    x: float
    y: float
    ours: bool = False


def scatter_chart(
    title: str, axes: tuple[str, str], dots: list[ScatterPoint], *, size: tuple[int, int] = SIZE
) -> NDArray[np.uint8]:
    """Return (H, W, 3) uint8 BGR: named dots, x on a logarithmic scale.

    axes : what x and y are
    Raises ValueError if there are no dots or an x is not positive, GraphicsError without OpenGL.
    """
    if not dots or not all(dot.x > 0 for dot in dots):
        raise ValueError("dots must be there, with positive x")
    return _picture(size, lambda plot: _draw_scatter(title, axes, dots, plot))


def _draw_scatter(title: str, axes: tuple[str, str], dots: list[ScatterPoint], size: tuple[float, float]) -> None:
    if not implot.begin_plot(title, imgui.ImVec2(*size), FLAGS):
        return
    implot.setup_axes(*axes)
    implot.setup_axis_scale(implot.ImAxis_.x1, implot.Scale_.log10)
    x, y = np.array([dot.x for dot in dots]), np.array([dot.y for dot in dots])
    implot.setup_axes_limits(x.min() / 2, x.max() * 4, -0.06 * y.max(), y.max() * 1.15, imgui.Cond_.always)
    taken: list[Box] = []
    for dot in sorted(dots, key=lambda dot: -dot.y):
        colour = imgui.ImVec4(*(HIGHLIGHT if dot.ours else ACCENT))
        spec = implot.Spec(marker=implot.Marker_.circle, marker_size=5.0, marker_fill_color=colour)
        implot.plot_scatter(dot.name, np.array([dot.x], float), np.array([dot.y], float), spec=spec)
        implot.plot_text(dot.name, dot.x, dot.y, imgui.ImVec2(*_free_place(dot, taken)))
    implot.end_plot()


def _free_place(dot: ScatterPoint, taken: list[Box]) -> tuple[float, float]:
    """Return where, in pixels from its dot, a name has room (right of it if nowhere), and take that room."""
    at, text = implot.plot_to_pixels(dot.x, dot.y), imgui.calc_text_size(dot.name)
    beside = text.x / 2 + 9
    places = [(side * beside, rise) for rise in (-8, 0, 8) for side in (1, -1)]
    boxes = [
        (at.x + x - text.x / 2, at.y + y - text.y / 2, at.x + x + text.x / 2, at.y + y + text.y / 2) for x, y in places
    ]
    free = [i for i, box in enumerate(boxes) if not any(_overlap(box, other) for other in taken)]
    chosen = free[0] if free else 0
    taken += [boxes[chosen], (at.x - 5, at.y - 5, at.x + 5, at.y + 5)]
    return places[chosen]


def _overlap(a: Box, b: Box) -> bool:
    return a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]
