"""Controls of the start window, each with a tooltip: rows with a label on the left, large buttons, level bars."""

from collections.abc import Sequence
from typing import NamedTuple

from imgui_bundle import imgui

from conf.render.ui.imgui_overlay import MUTED
from conf.render.ui.theme import AMBER, GREEN, RAISED, SELECTED, SELECTED_HOVERED
from conf.render.ui.wrapped_text import warning
from conf.start.devices.choices import Choice, selected_index
from conf.start.gui.tooltips import tooltip_of

LABEL_EMS = 6.2  # width of the labels, in text heights
TOOLTIP_EMS = 20.0
TOOLTIP_LINES = 5  # that fit below the mouse
LEVEL_EMS = 0.45  # height of a level bar
LOUD = 0.85  # of a level bar: -9 dBFS, close to clipping


class FieldInput(NamedTuple):
    """A text field. text : its content; entered : Enter was pressed in it; left : it was left after a change"""

    text: str
    entered: bool
    left: bool


def add_tooltip(label: str) -> None:
    """Show the text of a control while the mouse rests on the widget that was drawn last."""
    if text := tooltip_of(label):
        show_tooltip(text)


def show_tooltip(text: str) -> None:
    """Show a text while the mouse rests on the widget that was drawn last.

    Not for one that the keyboard has reached, nor while something is typed: the text would cover the next rows.
    """
    io = imgui.get_io()
    if io.want_text_input or io.nav_visible:
        return
    if imgui.is_item_hovered(imgui.HoveredFlags_.for_tooltip | imgui.HoveredFlags_.no_nav_override):
        _place_tooltip()
        imgui.begin_tooltip()
        imgui.push_text_wrap_pos(TOOLTIP_EMS * imgui.get_font_size())
        imgui.text_unformatted(text)
        imgui.pop_text_wrap_pos()
        imgui.end_tooltip()


def _place_tooltip() -> None:
    """Put the next tooltip beside the mouse, inside of the window. After a key ImGui would leave it elsewhere."""
    mouse, size, gap = imgui.get_mouse_pos(), imgui.get_io().display_size, imgui.get_font_size()
    is_right, is_low = mouse.x > size.x - (TOOLTIP_EMS + 3) * gap, mouse.y > size.y - TOOLTIP_LINES * 1.3 * gap
    at = imgui.ImVec2(mouse.x + (-gap if is_right else gap), mouse.y + (-gap if is_low else gap))
    imgui.set_next_window_pos(at, imgui.Cond_.always, imgui.ImVec2(float(is_right), float(is_low)))


def label(text: str) -> None:
    """Draw the label of a row; the next widget fills the rest."""
    imgui.align_text_to_frame_padding()
    imgui.text(text)
    add_tooltip(text)
    next_column()


def next_column() -> None:
    """Go to where the widgets of rows begin; the next one fills the rest."""
    imgui.same_line(imgui.get_style().window_padding.x + LABEL_EMS * imgui.get_font_size())
    imgui.set_next_item_width(-1)


def text_field(text: str, value: str, *, hint: str = "", error: str = "", width: float = -1) -> FieldInput:
    """Draw a row with a text field, and its error below it. width : pixels, -1 for the rest of the row"""
    label(text)
    imgui.set_next_item_width(width)
    entered, new = imgui.input_text_with_hint(f"##{text}", hint, value, imgui.InputTextFlags_.enter_returns_true)
    left = imgui.is_item_deactivated_after_edit()
    if error:
        draw_error(error)
    else:
        add_tooltip(text)
    return FieldInput(new, entered, left)


def draw_error(text: str, *, lines: int | None = None) -> None:
    """Draw a sentence below the widgets of rows, in a warning colour.

    lines : 1 to shorten it to one, and show the whole while the mouse rests there
    """
    imgui.dummy(imgui.ImVec2(0, 0))
    next_column()
    short = shortened(text, imgui.get_content_region_avail().x) if lines == 1 else text
    warning(short)
    if short != text:
        show_tooltip(text)


def combo_box(text: str, choices: Sequence[Choice], setting: str | None) -> str | None:
    """Draw a row with a drop-down list. Returns the setting of the row that is selected."""
    label(text)
    index = selected_index(choices, setting)
    changed, new = imgui.combo(f"##{text}", index, [choice.label for choice in choices])
    add_tooltip(text)
    return choices[new].value if changed else setting


def checkbox(text: str, description: str, value: bool) -> bool:
    """Draw a row with a check box and what it means. Returns whether it is checked."""
    label(text)
    checked = imgui.checkbox(f"{description}##{text}", value)[1]
    add_tooltip(text)
    return checked


def button(text: str, width: float = 0.0, *, is_main: bool = False) -> bool:
    """Draw a button, as wide as its text for width 0, as the rest of the row for -1. Returns whether it was pressed.

    is_main : it is what most people want to do next
    """
    if is_main:
        imgui.push_style_color(imgui.Col_.button, imgui.ImVec4(*SELECTED))
        imgui.push_style_color(imgui.Col_.button_hovered, imgui.ImVec4(*SELECTED_HOVERED))
    pressed = imgui.button(text, imgui.ImVec2(width, 0))
    if is_main:
        imgui.pop_style_color(2)
    add_tooltip(text)
    return pressed


def heading(text: str) -> None:
    """Draw the heading of a section."""
    imgui.dummy(imgui.ImVec2(0, 0.15 * imgui.get_font_size()))
    imgui.separator_text(text)


def level_bar(level: float) -> None:
    """Draw a level from 0 to 1 over the rest of the row, in another colour where it is loud."""
    width, height = imgui.get_content_region_avail().x, LEVEL_EMS * imgui.get_font_size()
    corner = imgui.get_cursor_screen_pos()
    imgui.dummy(imgui.ImVec2(width, height))
    draw_list = imgui.get_window_draw_list()
    for start, end, colour in (0.0, 1.0, RAISED), (0.0, min(level, LOUD), GREEN), (LOUD, level, AMBER):
        if end > start:
            low = imgui.ImVec2(corner.x + start * width, corner.y)
            high = imgui.ImVec2(corner.x + end * width, corner.y + height)
            draw_list.add_rect_filled(low, high, imgui.get_color_u32(imgui.ImVec4(*colour)))


def row_button(text: str, detail: str, identity: str, tooltip: str) -> bool:
    """Draw a row of a list with a text on the left and a muted one on the right. Returns whether it was pressed."""
    width = imgui.get_content_region_avail().x
    pressed = imgui.selectable(f"##{identity}", False)[0]
    add_tooltip(tooltip)
    detail_width = imgui.calc_text_size(detail).x
    imgui.same_line()
    imgui.set_cursor_pos_x(0.0)
    imgui.text_unformatted(shortened(text, width - detail_width - imgui.get_font_size()))
    imgui.same_line(width - detail_width)
    imgui.text_colored(imgui.ImVec4(*MUTED), detail)
    return pressed


def shortened(text: str, width: float) -> str:
    """Return a text that is at most `width` pixels wide, its end replaced by three dots if necessary."""
    if imgui.calc_text_size(text).x <= width:
        return text
    while text and imgui.calc_text_size(f"{text}...").x > width:
        text = text[:-1]
    return f"{text}..."


def centred_text(text: str, colour: tuple[float, float, float, float]) -> None:
    """Draw a line of text in the middle of the panel."""
    indent = (imgui.get_content_region_avail().x - imgui.calc_text_size(text).x) / 2
    imgui.set_cursor_pos_x(imgui.get_cursor_pos_x() + max(0.0, indent))
    imgui.text_colored(imgui.ImVec4(*colour), text)
