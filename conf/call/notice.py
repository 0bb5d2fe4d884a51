"""The panel in the middle of the window of a call: the code while one waits."""

from imgui_bundle import imgui

from conf.call.view import Notice
from conf.render.ui.hud import Size, padded, spaced_hyphens
from conf.render.ui.imgui_overlay import ACCENT, MUTED, TEXT, TEXT_PX, ImGuiOverlay, panel

# Pixels at scale 1.
LARGE_PX = 44.0
SPACING = 8.0
MARGIN = 14.0
OPACITY = 0.86


def notice_size(overlay: ImGuiOverlay, notice: Notice) -> Size:
    """Return the size of the panel, in a narrow window with a smaller code. Call it inside `overlay.frame`."""
    rows = _rows(overlay, notice)
    scale = overlay.scale
    width = max(size[0] for _, _, _, size in rows) + 2 * MARGIN * scale
    height = sum(size[1] for *_, size in rows) + SPACING * scale * (len(rows) - 1) + 2 * MARGIN * scale
    return padded(width, height)


def draw_notice(overlay: ImGuiOverlay, notice: Notice, corner: tuple[float, float]) -> None:
    """Draw the panel with its upper left corner at these pixels. Call it inside `overlay.frame`."""
    width, height = notice_size(overlay, notice)
    padding = imgui.get_style().window_padding
    imgui.set_next_window_bg_alpha(OPACITY)
    with panel("notice", corner, (0.0, 0.0), (width - 2 * padding.x, height - 2 * padding.y)):
        draw = imgui.get_window_draw_list()
        y = corner[1] + padding.y + MARGIN * overlay.scale
        for text, font_px, colour, size in _rows(overlay, notice):
            imgui.push_font(overlay.bold if text == notice.large else overlay.regular, font_px)
            x = corner[0] + (width - size[0]) / 2
            draw.add_text(imgui.ImVec2(x, y), imgui.get_color_u32(imgui.ImVec4(*colour)), text)
            imgui.pop_font()
            y += size[1] + SPACING * overlay.scale


def _rows(overlay: ImGuiOverlay, notice: Notice) -> list[tuple[str, float, tuple[float, float, float, float], Size]]:
    """Return text, font size at scale 1, colour and size of each row."""
    room = max(overlay.size[0] - 4 * MARGIN * overlay.scale - padded(0, 0)[0], 1.0)
    rows = [(notice.title, TEXT_PX, TEXT, _size(overlay.regular, TEXT_PX, notice.title))]
    if notice.large:
        large = LARGE_PX * min(1.0, room / _size(overlay.bold, LARGE_PX, notice.large)[0])
        rows.append((notice.large, large, ACCENT, _size(overlay.bold, large, notice.large)))
    lines = [spaced_hyphens(line) for line in notice.lines]
    return rows + [(line, TEXT_PX, MUTED, _size(overlay.regular, TEXT_PX, line)) for line in lines]


def _size(font: imgui.ImFont, font_px: float, text: str) -> Size:
    imgui.push_font(font, font_px)
    size = imgui.calc_text_size(text)
    imgui.pop_font()
    return size.x, size.y
