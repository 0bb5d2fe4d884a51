"""The meter: what the call costs beside raw pixels, drawn over the picture."""

from dataclasses import dataclass

import numpy as np
from imgui_bundle import imgui, implot

from conf.render.ui.imgui_overlay import (
    ACCENT,
    MUTED,
    PADDING,
    TITLE_PX,
    ImGuiOverlay,
    interface_scale,
    lines_height,
    panel,
)

WIDTH = 158.0  # of what the panel holds, at interface scale 1, pixels
CURVE_HEIGHT = 46.0
MARGIN = 8.0
SMALL_HEIGHT = 400.0  # below so many pixels (at scale 1) only the first lines are shown
SMALL_ROWS = 4

STATE_COLOURS = {
    "receiving": (0.35, 0.90, 0.50, 1.0),
    "no face": (1.00, 0.80, 0.30, 1.0),
    "waiting": (0.66, 0.71, 0.77, 1.0),
    "lost": (1.00, 0.42, 0.38, 1.0),
    "paused": (0.66, 0.71, 0.77, 1.0),
}


@dataclass(frozen=True)
class CallStats:
    """What the meter shows.

    state : "receiving", "no face", "waiting", "lost", "paused" or any other short text
    fps : pictures drawn a second
    bytes_per_frame, wire_kbps : what travels, UDP/IP headers counted
    raw_bytes_per_frame, raw_kbps : the sender's picture as plain RGB pixels
    ratio : raw over wire
    saved_percent : of the raw traffic
    points : control points a frame carries, against width x height pixels: the thesis's own count
    history : kbit/s, oldest first, over the last `history_seconds`
    """

    state: str
    fps: float
    bytes_per_frame: float
    wire_kbps: float
    raw_bytes_per_frame: float
    raw_kbps: float
    ratio: float
    saved_percent: float
    points: int
    width: int
    height: int
    frames_received: int
    frames_lost: int
    frames_late: int
    playout_delay_ms: float
    jitter_ms: float
    round_trip_ms: float | None = None
    history: tuple[float, ...] = ()
    history_seconds: float = 0.0


def format_bitrate(kbps: float) -> str:
    """Return a bit rate as people read it: 5.8 kbit/s, 27.6 Mbit/s."""
    return f"{kbps:.1f} kbit/s" if kbps < 1000 else f"{kbps / 1000:.1f} Mbit/s"


def format_saved(percent: float) -> str:
    """Return the share saved without rounding it up to all: 99.98, 99.995."""
    digits = 2 if percent < 99.99 else 3
    return f"{min(percent, 99.999):.{digits}f} %"


def stat_lines(reading: CallStats) -> list[tuple[str, str]]:
    """Return the lines of the meter below its title, each a name and a value."""
    trip = "" if reading.round_trip_ms is None else f"{reading.round_trip_ms:.0f} ms"
    lines = [
        ("raw pixels", format_bitrate(reading.raw_kbps)),
        ("a raw frame", f"{reading.raw_bytes_per_frame:,.0f} B"),
        ("ratio", f"{reading.ratio:,.0f} : 1"),
        ("saved", format_saved(reading.saved_percent)),
        (f"{reading.points} points", f"{reading.width * reading.height:,} pixels"),
        ("received", f"{reading.frames_received:,}"),
        ("lost / late", f"{reading.frames_lost:,} / {reading.frames_late:,}"),
        ("playout delay", f"{reading.playout_delay_ms:.0f} ms"),
        ("jitter", f"{reading.jitter_ms:.1f} ms"),
        ("round trip", trip),
    ]
    return [(name, value) for name, value in lines if value]


def covered_width(size: tuple[int, int], pixel_ratio: float) -> float:
    """Return how many pixels from the left the meter covers of a picture of this width and height."""
    scale = interface_scale(size, pixel_ratio)
    return (MARGIN + WIDTH + 2 * PADDING) * scale


def draw_stats(overlay: ImGuiOverlay, reading: CallStats) -> None:
    """Draw the meter in the upper left corner. To be called inside `overlay.frame`."""
    scale = overlay.scale
    small = overlay.size[1] / scale < SMALL_HEIGHT
    lines = stat_lines(reading)[: SMALL_ROWS if small else None]
    spacing = imgui.get_style().item_spacing.y
    height = lines_height(len(lines) + 2) + TITLE_PX * scale + spacing
    if not small:
        height += CURVE_HEIGHT * scale + spacing + lines_height(1) + spacing
    with panel("meter", (MARGIN * scale, MARGIN * scale), (0.0, 0.0), (WIDTH * scale, height)):
        _draw_state(reading)
        _draw_headline(overlay, reading)
        if not small:
            _draw_curve(reading, scale)
        _draw_rows(lines)


def _draw_state(reading: CallStats) -> None:
    _coloured(STATE_COLOURS.get(reading.state, ACCENT), reading.state)
    _right(f"{reading.fps:.0f} fps", MUTED)


def _draw_headline(overlay: ImGuiOverlay, reading: CallStats) -> None:
    imgui.push_font(overlay.bold, TITLE_PX)
    imgui.text(format_bitrate(reading.wire_kbps))
    imgui.pop_font()
    imgui.text(f"{reading.bytes_per_frame:,.0f} B a frame")
    _right("with UDP/IP", MUTED)


def _draw_curve(reading: CallStats, scale: float) -> None:
    values = np.asarray(reading.history or (0.0,), dtype=np.float64)
    if len(values) == 1:
        values = np.repeat(values, 2)
    top = max(float(values.max()) * 1.15, 1.0)
    x = np.linspace(0.0, 1.0, len(values))
    bare = implot.AxisFlags_.no_decorations
    implot.push_style_var(implot.StyleVar_.plot_padding, imgui.ImVec2(0, 0))
    implot.push_style_color(implot.Col_.frame_bg, imgui.ImVec4(0, 0, 0, 0))
    implot.push_style_color(implot.Col_.plot_bg, imgui.ImVec4(1, 1, 1, 0.05))
    implot.push_style_color(implot.Col_.plot_border, imgui.ImVec4(0, 0, 0, 0))
    if implot.begin_plot("##traffic", imgui.ImVec2(WIDTH * scale, CURVE_HEIGHT * scale), implot.Flags_.canvas_only):
        implot.setup_axes("", "", bare, bare)
        implot.setup_axes_limits(0.0, 1.0, 0.0, top, imgui.Cond_.always)
        implot.plot_shaded("kbit/s", x, values, spec=implot.Spec(fill_color=imgui.ImVec4(*ACCENT), fill_alpha=0.25))
        line = implot.Spec(line_color=imgui.ImVec4(*ACCENT), line_weight=1.5 * scale)
        implot.plot_line("kbit/s", x, values, spec=line)
        implot.end_plot()
    implot.pop_style_color(3)
    implot.pop_style_var()
    _coloured(MUTED, f"last {reading.history_seconds:.0f} s" if reading.history_seconds else "traffic")
    _right(f"peak {format_bitrate(float(values.max()))}", MUTED)


def _draw_rows(lines: list[tuple[str, str]]) -> None:
    for name, value in lines:
        _coloured(MUTED, name)
        _right(value)


def _coloured(colour: tuple[float, float, float, float], text: str) -> None:
    imgui.text_colored(imgui.ImVec4(*colour), text)


def _right(text: str, colour: tuple[float, float, float, float] | None = None) -> None:
    """Write text at the right edge of the line that was begun."""
    imgui.same_line(imgui.get_window_width() - imgui.get_style().window_padding.x - imgui.calc_text_size(text).x)
    if colour is None:
        imgui.text(text)
    else:
        _coloured(colour, text)
