"""Statistics over the image: one line, or a panel with the call's bit rate and what raw video would need."""

import numpy as np
from imgui_bundle import imgui, implot

from conf.receiver.call_stats import CallStats
from conf.render.ui.hud import Size, figure_width, padded
from conf.render.ui.imgui_overlay import (
    ACCENT,
    MUTED,
    PADDING,
    TEXT,
    TITLE_PX,
    ImGuiOverlay,
    interface_scale,
    lines_height,
    panel,
)

Colour = tuple[float, float, float, float]

# Pixels at scale 1.
WIDTH = 158.0  # of the panel's content
CURVE_HEIGHT = 46.0
MARGIN = 8.0
SMALL_HEIGHT = 400.0  # in an image less high only SMALL_ROWS lines are shown
SMALL_ROWS = 4
LINE_GAP = 12.0  # between two figures of the line

STATE_COLOURS = {
    "receiving": (0.35, 0.90, 0.50, 1.0),
    "no face": (1.00, 0.80, 0.30, 1.0),
    "waiting": MUTED,
    "lost": (1.00, 0.42, 0.38, 1.0),
    "paused": MUTED,
}


def format_bitrate(kbps: float) -> str:
    """Return a bit rate with its unit: 5.8 kbit/s, 27.6 Mbit/s."""
    return f"{kbps:.1f} kbit/s" if kbps < 1000 else f"{kbps / 1000:.1f} Mbit/s"


def format_saved(ratio: float) -> str:
    """Return the percentage saved at a compression ratio, never rounded up to 100: 99.98 %, 99.995 %."""
    percent = 100 * (1 - 1 / ratio) if ratio > 0 else 0.0
    digits = 2 if percent < 99.99 else 3
    return f"{min(percent, 99.999):.{digits}f} %"


def stat_lines(stats: CallStats) -> list[tuple[str, str]]:
    """Return the lines below the headline, each a name and a value."""
    traffic = stats.traffic
    lines = [
        ("raw pixels", format_bitrate(traffic.raw_kbps)),
        ("a raw frame", f"{traffic.raw_bytes_per_frame:,.0f} B"),
        ("ratio", f"{traffic.ratio:,.0f} : 1"),
        ("saved", format_saved(traffic.ratio)),
        (f"{stats.points} points", f"{stats.width * stats.height:,} pixels"),
        ("received", f"{traffic.frames_received:,}"),
        ("lost / late", f"{traffic.frames_lost:,} / {traffic.frames_late:,}"),
        ("playout delay", f"{traffic.playout_delay_ms:.0f} ms"),
        ("jitter", f"{traffic.jitter_ms:.1f} ms"),
    ]
    if stats.round_trip_ms is not None:
        lines.append(("round trip", f"{stats.round_trip_ms:.0f} ms"))
    return lines


def covered_width(size: tuple[int, int], pixel_ratio: float) -> float:
    """Return the width, in pixels from the left, that the panel covers of an image of this width and height."""
    return (MARGIN + WIDTH + 2 * PADDING) * interface_scale(size, pixel_ratio)


def line_parts(stats: CallStats) -> list[tuple[str, Colour | None]]:
    """Return the figures of the one line, each with its colour; None is that of text."""
    parts: list[tuple[str, Colour | None]] = [(stats.state, STATE_COLOURS.get(stats.state, ACCENT))]
    if stats.traffic.datagrams:
        parts.append((format_bitrate(stats.traffic.wire_kbps), None))
    if stats.traffic.ratio > 0:
        parts.append((f"{stats.traffic.ratio:,.0f} : 1", None))
    return [*parts, (f"{stats.fps:.0f} fps", MUTED), ("M: more", MUTED)]


def stats_size(overlay: ImGuiOverlay, stats: CallStats, *, is_open: bool) -> Size:
    """Return the size of the line, or of the panel if it is open. Call it inside `overlay.frame`."""
    if is_open:
        return padded(WIDTH * overlay.scale, _panel_height(overlay, stats))
    widths = [figure_width(text) for text, _ in line_parts(stats)]
    return padded(sum(widths) + LINE_GAP * overlay.scale * (len(widths) - 1), lines_height(1))


def draw_stats_line(overlay: ImGuiOverlay, stats: CallStats) -> None:
    """Draw the line in the upper left corner. Call it inside `overlay.frame`."""
    width, height = stats_size(overlay, stats, is_open=False)
    padding = imgui.get_style().window_padding
    corner = (MARGIN * overlay.scale, MARGIN * overlay.scale)
    with panel("stats line", corner, (0.0, 0.0), (width - 2 * padding.x, height - 2 * padding.y)):
        left = padding.x
        for number, (text, colour) in enumerate(line_parts(stats)):
            if number:
                imgui.same_line(left)
            _coloured(colour or TEXT, text)
            left += figure_width(text) + LINE_GAP * overlay.scale


def draw_stats(overlay: ImGuiOverlay, stats: CallStats) -> None:
    """Draw the panel in the upper left corner. Call it inside `overlay.frame`."""
    scale = overlay.scale
    is_small = _is_small(overlay)
    lines = stat_lines(stats)[: SMALL_ROWS if is_small else None]
    height = _panel_height(overlay, stats)
    with panel("stats", (MARGIN * scale, MARGIN * scale), (0.0, 0.0), (WIDTH * scale, height)):
        _coloured(STATE_COLOURS.get(stats.state, ACCENT), stats.state)
        _right(f"{stats.fps:.0f} fps", MUTED)
        imgui.push_font(overlay.bold, TITLE_PX)
        imgui.text(format_bitrate(stats.traffic.wire_kbps))
        imgui.pop_font()
        imgui.text(f"{stats.traffic.wire_bytes_per_frame:,.0f} B a frame")
        _right("with UDP/IP", MUTED)
        if not is_small:
            _draw_curve(stats, scale)
        for name, value in lines:
            _coloured(MUTED, name)
            _right(value)


def _is_small(overlay: ImGuiOverlay) -> bool:
    return overlay.size[1] / overlay.scale < SMALL_HEIGHT


def _panel_height(overlay: ImGuiOverlay, stats: CallStats) -> float:
    """Return the height of the panel's content."""
    is_small = _is_small(overlay)
    lines = len(stat_lines(stats)[: SMALL_ROWS if is_small else None])
    spacing = imgui.get_style().item_spacing.y
    height = lines_height(lines + 2) + TITLE_PX * overlay.scale + spacing
    return height if is_small else height + CURVE_HEIGHT * overlay.scale + 2 * spacing + lines_height(1)


def _draw_curve(stats: CallStats, scale: float) -> None:
    values = np.asarray(stats.history or (0.0,), dtype=np.float64)
    if len(values) == 1:
        values = np.repeat(values, 2)
    top = max(float(values.max()) * 1.15, 1.0)
    x = np.linspace(0.0, 1.0, len(values))
    no_decorations = implot.AxisFlags_.no_decorations
    implot.push_style_var(implot.StyleVar_.plot_padding, imgui.ImVec2(0, 0))
    implot.push_style_color(implot.Col_.frame_bg, imgui.ImVec4(0, 0, 0, 0))
    implot.push_style_color(implot.Col_.plot_bg, imgui.ImVec4(1, 1, 1, 0.05))
    implot.push_style_color(implot.Col_.plot_border, imgui.ImVec4(0, 0, 0, 0))
    if implot.begin_plot("##traffic", imgui.ImVec2(WIDTH * scale, CURVE_HEIGHT * scale), implot.Flags_.canvas_only):
        implot.setup_axes("", "", no_decorations, no_decorations)
        implot.setup_axes_limits(0.0, 1.0, 0.0, top, imgui.Cond_.always)
        implot.plot_shaded("kbit/s", x, values, spec=implot.Spec(fill_color=imgui.ImVec4(*ACCENT), fill_alpha=0.25))
        line = implot.Spec(line_color=imgui.ImVec4(*ACCENT), line_weight=1.5 * scale)
        implot.plot_line("kbit/s", x, values, spec=line)
        implot.end_plot()
    implot.pop_style_color(3)
    implot.pop_style_var()
    _coloured(MUTED, f"last {stats.history_seconds:.0f} s" if stats.history_seconds else "traffic")
    _right(f"peak {format_bitrate(float(values.max()))}", MUTED)


def _coloured(colour: Colour, text: str) -> None:
    imgui.text_colored(imgui.ImVec4(*colour), text)


def _right(text: str, colour: tuple[float, float, float, float] | None = None) -> None:
    """Write text at the right edge of the current line."""
    imgui.same_line(imgui.get_window_width() - imgui.get_style().window_padding.x - imgui.calc_text_size(text).x)
    if colour is None:
        imgui.text(text)
    else:
        _coloured(colour, text)
