"""Scatter charts with a logarithmic x axis, the names beside the points."""

from dataclasses import dataclass

import numpy as np
from imgui_bundle import imgui, implot
from numpy.typing import NDArray

from conf.render.ui.charts import FLAGS, SIZE, render_plot
from conf.render.ui.imgui_overlay import ACCENT

HIGHLIGHT = (0.35, 0.90, 0.50, 1.0)
Box = tuple[float, float, float, float]  # left, top, right, bottom, pixels


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
    return render_plot(size, lambda plot: _draw_scatter(title, axes, points, plot))


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
