"""Statistics over the image: one line, or a panel with the call's bit rate and what raw video would need."""

from dataclasses import astuple
from operator import attrgetter
from typing import NamedTuple

import numpy as np
from imgui_bundle import imgui, implot

from conf.protocol.statistics import MediaBytes
from conf.receiver.call_stats import CallStats
from conf.render.ui.hud import Size, figure_width, padded
from conf.render.ui.imgui_overlay import (
    ACCENT,
    MUTED,
    PADDING,
    SCALE,
    TEXT,
    TITLE_PX,
    ImGuiOverlay,
    lines_height,
    panel,
)

Colour = tuple[float, float, float, float]

# Pixels at scale 1.
WIDTH = 158.0  # of the panel's content
CURVE_HEIGHT = 46.0
MARGIN = 8.0
SMALL_HEIGHT = 430.0  # in an image less high only SMALL_ROWS lines are shown
SMALL_ROWS = 4
LINE_GAP = 12.0  # between two figures of the line
METER_WIDTH, METER_HEIGHT = 36.0, 6.0  # of a sound level
SWATCH = 8.0  # side of the square that tells the colour of a medium

STATE_COLOURS = {
    "receiving": (0.35, 0.90, 0.50, 1.0),
    "no face": (1.00, 0.80, 0.30, 1.0),
    "waiting": MUTED,
    "lost": (1.00, 0.42, 0.38, 1.0),
    "paused": MUTED,
}
WARNING = STATE_COLOURS["no face"]
SOUND_OFF = "sound off"
VOICE = "voice"
# In the order of MediaBytes, from the bottom of the curve to its top.
MEDIA = {"face": ACCENT, "voice": STATE_COLOURS["receiving"], "portrait": WARNING, "overhead": (0.55, 0.58, 0.64, 1.0)}
_AMOUNTS = attrgetter(*MEDIA)  # of MediaBytes; astuple() of a minute of them takes a millisecond


class LinePart(NamedTuple):
    """A figure of the one line. colour : None is that of text; level : of sound, 0 to 1, shown behind the text"""

    text: str
    colour: Colour | None
    level: float | None = None
    optional: bool = False  # left out where there is no room


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
        *voice_lines(stats),
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


def voice_lines(stats: CallStats) -> list[tuple[str, str]]:
    """Return the lines about the callers' sound; the value of VOICE is empty where its level is drawn."""
    if (voice := stats.voice) is None:
        return []
    return [
        (VOICE, voice.note.removeprefix(f"{VOICE} ")),
        ("sound", "off" if voice.muted else f"volume {voice.volume_db:+.0f} dB"),
    ]


def media_lines(amounts: MediaBytes) -> list[tuple[str, str]]:
    """Return the name of each medium and its rate; amounts : bytes a second"""
    return [(name, f"{amount:,.0f} B/s") for name, amount in zip(MEDIA, astuple(amounts), strict=True)]


def covered_width(size: tuple[int, int], pixel_ratio: float) -> float:
    """Return the width, in pixels from the left, that the panel covers of an image of this width and height."""
    return (MARGIN + WIDTH + 2 * PADDING) * SCALE.scale(size, pixel_ratio)


def line_parts(stats: CallStats) -> list[LinePart]:
    """Return the figures of the one line."""
    parts = [LinePart(stats.state, STATE_COLOURS.get(stats.state, ACCENT))]
    if stats.traffic.datagrams:
        parts.append(LinePart(format_bitrate(stats.traffic.wire_kbps), None, optional=True))
    if stats.traffic.ratio > 0:
        parts.append(LinePart(f"{stats.traffic.ratio:,.0f} : 1", None, optional=True))
    parts.append(LinePart(f"{stats.fps:.0f} fps", MUTED, optional=True))
    if (voice := stats.voice) is not None:
        parts.append(LinePart(SOUND_OFF, WARNING) if voice.muted else LinePart(VOICE, MUTED, voice.level))
        parts += [LinePart(voice.note, WARNING)] if voice.note else []
    return [*parts, LinePart("M: more", MUTED, optional=True)]


def fitting_parts(parts: list[LinePart], overlay: ImGuiOverlay) -> list[LinePart]:
    """Return the parts for which the image has room: of the optional ones the last are left out."""
    room = overlay.size[0] - 2 * MARGIN * overlay.scale - padded(0, 0)[0]
    while _line_width(parts, overlay.scale) > room and (optional := [part for part in parts if part.optional]):
        parts = [part for part in parts if part is not optional[-1]]
    return parts


def stats_size(overlay: ImGuiOverlay, stats: CallStats, *, is_open: bool) -> Size:
    """Return the size of the line, or of the panel if it is open. Call it inside `overlay.frame`."""
    if is_open:
        return padded(WIDTH * overlay.scale, _panel_height(overlay, stats))
    return line_size(overlay, line_parts(stats))


def line_size(overlay: ImGuiOverlay, parts: list[LinePart]) -> Size:
    """Return the size of a line of figures, as far as they fit. Call it inside `overlay.frame`."""
    return padded(_line_width(fitting_parts(parts, overlay), overlay.scale), lines_height(1))


def draw_stats_line(overlay: ImGuiOverlay, stats: CallStats) -> None:
    """Draw the line in the upper left corner. Call it inside `overlay.frame`."""
    draw_line(overlay, line_parts(stats))


def draw_line(overlay: ImGuiOverlay, parts: list[LinePart]) -> None:
    """Draw a line of figures in the upper left corner. Call it inside `overlay.frame`."""
    width, height = line_size(overlay, parts)
    padding = imgui.get_style().window_padding
    scale = overlay.scale
    with panel(
        "stats line", (MARGIN * scale, MARGIN * scale), (0.0, 0.0), (width - 2 * padding.x, height - 2 * padding.y)
    ):
        left = padding.x
        for number, part in enumerate(fitting_parts(parts, overlay)):
            if number:
                imgui.same_line(left)
            _coloured(part.colour or TEXT, part.text)
            if part.level is not None:
                imgui.same_line(left + figure_width(part.text) + LINE_GAP / 2 * scale)
                _draw_level(part.level, scale)
            left += _part_width(part, scale) + LINE_GAP * scale


def draw_stats(overlay: ImGuiOverlay, stats: CallStats, *, top: float | None = None) -> None:
    """Draw the panel at the left edge. Call it inside `overlay.frame`.

    top : its upper edge, pixels; None for the corner
    """
    scale = overlay.scale
    top = MARGIN * scale if top is None else top
    is_small = _is_small(overlay)
    lines = stat_lines(stats)[: SMALL_ROWS if is_small else None]
    height = _panel_height(overlay, stats)
    with panel("stats", (MARGIN * scale, top), (0.0, 0.0), (WIDTH * scale, height)):
        _coloured(STATE_COLOURS.get(stats.state, ACCENT), stats.state)
        _right(f"{stats.fps:.0f} fps", MUTED)
        imgui.push_font(overlay.bold, TITLE_PX)
        imgui.text(format_bitrate(stats.traffic.wire_kbps))
        imgui.pop_font()
        imgui.text(f"{stats.traffic.wire_bytes_per_frame:,.0f} B a frame")
        _right("with UDP/IP", MUTED)
        if not is_small:
            _draw_curve(stats, scale)
            _draw_media(stats.traffic.media_bytes_per_second, scale)
        for name, value in lines:
            _coloured(MUTED, name)
            if name == VOICE and not value and stats.voice is not None:
                imgui.same_line(imgui.get_window_width() - imgui.get_style().window_padding.x - METER_WIDTH * scale)
                _draw_level(stats.voice.level, scale)
            else:
                _right(value, WARNING if name == VOICE else None)


def _is_small(overlay: ImGuiOverlay) -> bool:
    return overlay.size[1] / overlay.scale < SMALL_HEIGHT


def _panel_height(overlay: ImGuiOverlay, stats: CallStats) -> float:
    """Return the height of the panel's content."""
    is_small = _is_small(overlay)
    lines = len(stat_lines(stats)[: SMALL_ROWS if is_small else None])
    spacing = imgui.get_style().item_spacing.y
    height = lines_height(lines + 2) + TITLE_PX * overlay.scale + spacing
    if is_small:
        return height
    return height + CURVE_HEIGHT * overlay.scale + lines_height(1 + len(MEDIA)) + 2 * spacing


def _line_width(parts: list[LinePart], scale: float) -> float:
    return sum(_part_width(part, scale) for part in parts) + LINE_GAP * scale * (len(parts) - 1)


def _part_width(part: LinePart, scale: float) -> float:
    meter = 0.0 if part.level is None else (LINE_GAP / 2 + METER_WIDTH) * scale
    return figure_width(part.text) + meter


def _draw_level(level: float, scale: float) -> None:
    """Draw a sound level, 0 to 1, as a bar at the cursor."""
    corner, line = imgui.get_cursor_screen_pos(), imgui.get_text_line_height()
    width, height = METER_WIDTH * scale, METER_HEIGHT * scale
    top = corner.y + (line - height) / 2
    draw = imgui.get_window_draw_list()
    for part, colour in ((1.0, (1.0, 1.0, 1.0, 0.15)), (level, MEDIA[VOICE])):
        end = imgui.ImVec2(corner.x + width * part, top + height)
        draw.add_rect_filled(imgui.ImVec2(corner.x, top), end, imgui.get_color_u32(imgui.ImVec4(*colour)))
    imgui.dummy(imgui.ImVec2(width, line))


def _draw_media(amounts: MediaBytes, scale: float) -> None:
    """Draw what each medium costs, with its colour in the curve."""
    side = SWATCH * scale
    for name, value in media_lines(amounts):
        corner, line = imgui.get_cursor_screen_pos(), imgui.get_text_line_height()
        top = corner.y + (line - side) / 2
        colour = imgui.get_color_u32(imgui.ImVec4(*MEDIA[name]))
        imgui.get_window_draw_list().add_rect_filled(
            imgui.ImVec2(corner.x, top), imgui.ImVec2(corner.x + side, top + side), colour
        )
        imgui.set_cursor_pos_x(imgui.get_cursor_pos_x() + 1.5 * side)
        _coloured(MUTED, name)
        _right(value)


def _draw_curve(stats: CallStats, scale: float) -> None:
    """Draw what each medium has cost, one above another."""
    rates = np.array([_AMOUNTS(amounts) for amounts in stats.history or (MediaBytes(),)], dtype=np.float64) * 8 / 1000
    if len(rates) == 1:
        rates = np.repeat(rates, 2, axis=0)
    sums = np.hstack([np.zeros((len(rates), 1)), np.cumsum(rates, axis=1)]).T.copy()  # (media + 1, n) kbit/s
    peak = float(sums[-1].max())
    top = max(peak * 1.15, 1.0)
    x = np.linspace(0.0, 1.0, len(rates))
    no_decorations = implot.AxisFlags_.no_decorations
    implot.push_style_var(implot.StyleVar_.plot_padding, imgui.ImVec2(0, 0))
    implot.push_style_color(implot.Col_.frame_bg, imgui.ImVec4(0, 0, 0, 0))
    implot.push_style_color(implot.Col_.plot_bg, imgui.ImVec4(1, 1, 1, 0.05))
    implot.push_style_color(implot.Col_.plot_border, imgui.ImVec4(0, 0, 0, 0))
    if implot.begin_plot("##traffic", imgui.ImVec2(WIDTH * scale, CURVE_HEIGHT * scale), implot.Flags_.canvas_only):
        implot.setup_axes("", "", no_decorations, no_decorations)
        implot.setup_axes_limits(0.0, 1.0, 0.0, top, imgui.Cond_.always)
        for (name, colour), below, above in zip(MEDIA.items(), sums[:-1], sums[1:], strict=True):
            implot.plot_shaded(
                name, x, below, above, spec=implot.Spec(fill_color=imgui.ImVec4(*colour), fill_alpha=0.75)
            )
        implot.end_plot()
    implot.pop_style_color(3)
    implot.pop_style_var()
    _coloured(MUTED, f"last {stats.history_seconds:.0f} s" if stats.history_seconds else "traffic")
    _right(f"peak {format_bitrate(peak)}", MUTED)


def _coloured(colour: Colour, text: str) -> None:
    imgui.text_colored(imgui.ImVec4(*colour), text)


def _right(text: str, colour: tuple[float, float, float, float] | None = None) -> None:
    """Write text at the right edge of the current line."""
    imgui.same_line(imgui.get_window_width() - imgui.get_style().window_padding.x - imgui.calc_text_size(text).x)
    if colour is None:
        imgui.text(text)
    else:
        _coloured(colour, text)
