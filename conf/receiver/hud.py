"""Short texts over the picture: the list of keys, and one line that says what just happened."""

from imgui_bundle import imgui

from conf.render.ui.imgui_overlay import ACCENT, MUTED, ImGuiOverlay, lines_height, panel
from conf.render.window.input_events import KEYS, MOUSE

HELP_OPACITY = 0.88  # it may lie over the meter
KEY_NAMES = {"space": "Space", "home": "Home", "escape": "Esc"}


def help_lines() -> list[tuple[str, str]]:
    """Return what each key and mouse movement does, keys that do the same in one line."""
    keys: dict[str, list[str]] = {}
    for key, (action, _) in KEYS.items():
        keys.setdefault(action, []).append(KEY_NAMES.get(key, key.upper()))
    texts = {action: text for action, text in KEYS.values() if text}
    return [(", ".join(keys[action]), text) for action, text in texts.items()] + list(MOUSE)


def draw_help(overlay: ImGuiOverlay) -> None:
    """Draw the list of keys in the middle. To be called inside `overlay.frame`."""
    lines = help_lines()
    column = max(imgui.calc_text_size(keys).x for keys, _ in lines) + 14 * overlay.scale
    width = column + max(imgui.calc_text_size(text).x for _, text in lines)
    centre = (overlay.size[0] / 2, overlay.size[1] / 2)
    imgui.set_next_window_bg_alpha(HELP_OPACITY)
    with panel("help", centre, (0.5, 0.5), (width, lines_height(len(lines)))):
        left = imgui.get_style().window_padding.x
        for keys, text in lines:
            imgui.text_colored(imgui.ImVec4(*ACCENT), keys)
            imgui.same_line(left + column)
            imgui.text(text)


def draw_toast(overlay: ImGuiOverlay, text: str) -> None:
    """Draw one line of text at the bottom, such as "saved conf.jpg". To be called inside `overlay.frame`."""
    place = (overlay.size[0] / 2, overlay.size[1] - 10 * overlay.scale)
    with panel("notice", place, (0.5, 1.0), (imgui.calc_text_size(text).x, lines_height(1))):
        imgui.text(text)


def draw_label(overlay: ImGuiOverlay, text: str, corner: tuple[float, float]) -> None:
    """Draw a small name whose lower left corner is at these pixels from the upper left. To be called as the others."""
    place = (corner[0] + 6 * overlay.scale, corner[1] - 6 * overlay.scale)
    with panel(f"label {place}", place, (0.0, 1.0), (imgui.calc_text_size(text).x, lines_height(1))):
        imgui.text_colored(imgui.ImVec4(*MUTED), text)
