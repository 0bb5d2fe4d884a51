"""Short texts over the image: list of keys, toast, name label. Call these functions inside `ImGuiOverlay.frame`."""

from imgui_bundle import imgui

from conf.render.ui.imgui_overlay import ACCENT, MUTED, PANEL, ImGuiOverlay, lines_height, panel

KEY_GAP = 14.0  # pixels at scale 1 between the longest key and the texts


def draw_help(
    overlay: ImGuiOverlay, lines: list[tuple[str, str]], centre: tuple[float, float], *, opacity: float = PANEL[3]
) -> None:
    """Draw a list of keys and what they do, centred at these pixels."""
    column = max(imgui.calc_text_size(keys).x for keys, _ in lines) + KEY_GAP * overlay.scale
    width = column + max(imgui.calc_text_size(text).x for _, text in lines)
    imgui.set_next_window_bg_alpha(opacity)
    with panel("help", centre, (0.5, 0.5), (width, lines_height(len(lines)))):
        left = imgui.get_style().window_padding.x
        for keys, text in lines:
            imgui.text_colored(imgui.ImVec4(*ACCENT), keys)
            imgui.same_line(left + column)
            imgui.text(text)


def draw_toast(
    text: str, anchor: tuple[float, float], *, max_width: float | None = None, opacity: float = PANEL[3]
) -> None:
    """Draw a message, such as "saved conf.jpg", whose lower middle is at these pixels.

    max_width : pixels after which the text is wrapped; None keeps it on one line
    """
    size = imgui.calc_text_size(text, wrap_width=max_width or -1.0)
    width = size.x if max_width is None else min(size.x + 2, max_width)
    imgui.set_next_window_bg_alpha(opacity)
    with panel("toast", anchor, (0.5, 1.0), (width, size.y)):
        imgui.push_text_wrap_pos(-1.0 if max_width is None else 0.0)
        imgui.text_unformatted(text)
        imgui.pop_text_wrap_pos()


def draw_label(overlay: ImGuiOverlay, text: str, corner: tuple[float, float]) -> None:
    """Draw a small name whose lower left corner is at these pixels from the upper left."""
    anchor = (corner[0] + 6 * overlay.scale, corner[1] - 6 * overlay.scale)
    with panel(f"label {anchor}", anchor, (0.0, 1.0), (imgui.calc_text_size(text).x, lines_height(1))):
        imgui.text_colored(imgui.ImVec4(*MUTED), text)
