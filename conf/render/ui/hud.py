"""Short texts over the image: list of keys, toast, name label, recording sign.

Call these functions inside `ImGuiOverlay.frame`; sizes include the panels' padding.
"""

from imgui_bundle import imgui

from conf.render.ui.imgui_overlay import ACCENT, MUTED, PANEL, ImGuiOverlay, lines_height, panel

KEY_GAP = 14.0  # pixels at scale 1 between the longest key and the texts
DOT_RADIUS = 4.5  # pixels at scale 1, of the recording sign
DOT_GAP = 5.0
SIGN_GAP = 14.0  # between two recordings
RECORDING = (0.96, 0.26, 0.21, 1.0)
HIGHLIGHTED_TEXT = (0.045, 0.055, 0.075, 1.0)

HAIR_SPACE = "\u200a"

Size = tuple[float, float]  # width and height, pixels


def spaced_hyphens(text: str) -> str:
    """Return a text for drawing in which the two hyphens of an option do not look like one dash."""
    return text.replace("--", f"-{HAIR_SPACE}-")


def padded(width: float, height: float) -> Size:
    """Return the size of a panel with a content of this width and height, pixels."""
    padding = imgui.get_style().window_padding
    return width + 2 * padding.x, height + 2 * padding.y


def help_size(overlay: ImGuiOverlay, lines: list[tuple[str, str]]) -> Size:
    """Return the size of the list that `draw_help` draws."""
    width = _key_column(overlay, lines) + max(imgui.calc_text_size(text).x for _, text in lines)
    return padded(width, lines_height(len(lines)))


def draw_help(
    overlay: ImGuiOverlay, lines: list[tuple[str, str]], centre: tuple[float, float], *, opacity: float = PANEL[3]
) -> None:
    """Draw a list of keys and what they do, centred at these pixels."""
    column = _key_column(overlay, lines)
    width = column + max(imgui.calc_text_size(text).x for _, text in lines)
    imgui.set_next_window_bg_alpha(opacity)
    with panel("help", centre, (0.5, 0.5), (width, lines_height(len(lines)))):
        left = imgui.get_style().window_padding.x
        for keys, text in lines:
            imgui.text_colored(imgui.ImVec4(*ACCENT), keys)
            imgui.same_line(left + column)
            imgui.text(text)


def toast_size(text: str, *, max_width: float | None = None) -> Size:
    """Return the size of the panel that `draw_toast` draws; max_width : of the text"""
    return padded(*_text_size(text, max_width))


def draw_toast(
    text: str,
    anchor: tuple[float, float],
    *,
    max_width: float | None = None,
    opacity: float = PANEL[3],
    name: str = "toast",
) -> None:
    """Draw a message, such as "saved conf.jpg", whose lower middle is at these pixels.

    max_width : pixels after which the text is wrapped; None keeps it on one line
    name : different for each of several messages
    """
    imgui.set_next_window_bg_alpha(opacity)
    with panel(name, anchor, (0.5, 1.0), _text_size(text, max_width)):
        imgui.push_text_wrap_pos(-1.0 if max_width is None else 0.0)
        imgui.text_unformatted(spaced_hyphens(text))
        imgui.pop_text_wrap_pos()


def label_size(text: str) -> Size:
    """Return the size of the panel that `draw_label` draws."""
    return padded(imgui.calc_text_size(text).x, lines_height(1))


def draw_label(text: str, corner: tuple[float, float], *, highlighted: bool = False) -> None:
    """Draw a small name whose upper left corner is at these pixels; highlighted, dark on the accent colour."""
    background, colour = (ACCENT, HIGHLIGHTED_TEXT) if highlighted else (PANEL, MUTED)
    imgui.push_style_color(imgui.Col_.window_bg, imgui.ImVec4(*background))
    with panel(f"label {corner}", corner, (0.0, 0.0), (imgui.calc_text_size(text).x, lines_height(1))):
        imgui.text_colored(imgui.ImVec4(*colour), text)
    imgui.pop_style_color()


def figure_width(text: str) -> float:
    """Return the width of a text whose digits are all as wide as a zero, so that running figures do not shake."""
    return float(imgui.calc_text_size("".join("0" if letter.isdigit() else letter for letter in text)).x)


def format_clock(seconds: float) -> str:
    """Return a running time: 0:07, 12:30, 1:02:03."""
    minutes, rest = divmod(int(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02}:{rest:02}" if hours else f"{minutes}:{rest:02}"


def sign_size(overlay: ImGuiOverlay, recordings: list[tuple[str, float]]) -> Size:
    """Return the size of the panel that `draw_recording_sign` draws."""
    return padded(_sign_width(overlay, recordings), lines_height(1))


def draw_recording_sign(
    overlay: ImGuiOverlay, recordings: list[tuple[str, float]], corner: tuple[float, float]
) -> None:
    """Draw a red dot and a clock for each recording, with the upper left corner at these pixels.

    recordings : key or name, and seconds since the start
    """
    scale = overlay.scale
    with panel("recording", corner, (0.0, 0.0), (_sign_width(overlay, recordings), lines_height(1))):
        colour = imgui.get_color_u32(imgui.ImVec4(*RECORDING))
        left = imgui.get_style().window_padding.x
        for name, seconds in recordings:
            if left > imgui.get_style().window_padding.x:
                imgui.same_line(left)
            at, radius = imgui.get_cursor_screen_pos(), DOT_RADIUS * scale
            middle = imgui.ImVec2(at.x + radius, at.y + imgui.get_text_line_height() / 2)
            imgui.get_window_draw_list().add_circle_filled(middle, radius, colour)
            text = _sign_text(name, seconds)
            imgui.set_cursor_pos_x(left + 2 * radius + DOT_GAP * scale)
            imgui.text_unformatted(text)
            left += 2 * radius + (DOT_GAP + SIGN_GAP) * scale + figure_width(text)


def _sign_text(name: str, seconds: float) -> str:
    return f"{name}  {format_clock(seconds)}"


def _sign_width(overlay: ImGuiOverlay, recordings: list[tuple[str, float]]) -> float:
    dots = len(recordings) * (2 * DOT_RADIUS + DOT_GAP) + (len(recordings) - 1) * SIGN_GAP
    return dots * overlay.scale + sum(figure_width(_sign_text(*recording)) for recording in recordings)


def _key_column(overlay: ImGuiOverlay, lines: list[tuple[str, str]]) -> float:
    return max(imgui.calc_text_size(keys).x for keys, _ in lines) + KEY_GAP * overlay.scale


def _text_size(text: str, max_width: float | None) -> Size:
    size = imgui.calc_text_size(spaced_hyphens(text), wrap_width=max_width or -1.0)
    return size.x if max_width is None else min(size.x + 2, max_width), size.y
