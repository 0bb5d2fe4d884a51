"""Widgets of a panel: one row each, the label left of it, and a tooltip with the text of gui.tooltips."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import NamedTuple

from imgui_bundle import imgui

from conf.animator.gui.tooltips import tooltip_of
from conf.render.ui.theme import SELECTED, SELECTED_HOVERED

LABEL_WIDTH = 0.40  # of a row
WIDE_LABEL_WIDTH = 0.58
TOOLTIP_EMS = 20.0  # width of a tooltip in text heights
BROWSE = "..."


class PathInput(NamedTuple):
    """What the user did with a path field: its text, whether it was confirmed, and whether a dialog is wanted."""

    text: str
    confirmed: bool
    browse: bool


def add_tooltip(label: str, kind: str = "") -> None:
    """Show the text of a control while the mouse rests on the widget that was drawn last."""
    text = tooltip_of(label, kind)
    if text and imgui.begin_item_tooltip():
        imgui.push_text_wrap_pos(TOOLTIP_EMS * imgui.get_font_size())
        imgui.text_unformatted(text)
        imgui.pop_text_wrap_pos()
        imgui.end_tooltip()


def label(text: str, width: float = LABEL_WIDTH, kind: str = "") -> None:
    """Draw the label of a row; the next widget fills the rest."""
    imgui.align_text_to_frame_padding()
    imgui.text(text)
    add_tooltip(text, kind)
    imgui.same_line(imgui.get_window_width() * width)
    imgui.set_next_item_width(-1)


def slider(
    text: str,
    value: float,
    limits: tuple[float, float],
    *,
    number_format: str = "%.2f",
    logarithmic: bool = False,
    label_width: float = LABEL_WIDTH,
    kind: str = "",
) -> float:
    """Draw a slider. Returns the value, clamped to the limits only if the user changed it."""
    label(text, label_width, kind)
    flags = imgui.SliderFlags_.always_clamp | (imgui.SliderFlags_.logarithmic if logarithmic else 0)
    changed, new = imgui.slider_float(f"##{text}", value, *limits, number_format, flags)
    add_tooltip(text, kind)
    return new if changed else value


def combo_box(text: str, value: str, names: Sequence[str]) -> str:
    """Draw a drop-down list. Returns the selected name; the first if `value` is not in the list."""
    label(text)
    names = list(names)
    _, index = imgui.combo(f"##{text}", names.index(value) if value in names else 0, names)
    add_tooltip(text)
    return names[index]


def text_field(text: str, value: str) -> str:
    """Draw a text field; a click selects all of its text. Returns the text."""
    label(text)
    value = imgui.input_text(f"##{text}", value, imgui.InputTextFlags_.auto_select_all)[1]
    add_tooltip(text)
    return value


def output_field(text: str, value: str) -> tuple[str, bool]:
    """Draw a text field for a file to write, and a button for a dialog. Returns the text, whether that was pressed."""
    label(text)
    imgui.set_next_item_width(-_button_width(BROWSE) - imgui.get_style().item_spacing.x)
    flags = imgui.InputTextFlags_.auto_select_all | imgui.InputTextFlags_.elide_left
    value = imgui.input_text(f"##{text}", value, flags)[1]
    add_tooltip(text)
    imgui.same_line()
    return value, button(f"{BROWSE}##{text}")


def path_field(hint: str, value: str, confirm: str) -> PathInput:
    """Draw a text field for a file name, with buttons for a dialog and to confirm; a click selects all of its text."""
    widths = (_button_width(text) + imgui.get_style().item_spacing.x for text in (BROWSE, confirm))
    imgui.set_next_item_width(-sum(widths))
    flags = imgui.InputTextFlags_.enter_returns_true | imgui.InputTextFlags_.elide_left
    entered, value = imgui.input_text_with_hint(f"##{hint}", hint, value, flags | imgui.InputTextFlags_.auto_select_all)
    add_tooltip(hint)
    imgui.same_line()
    browse = button(f"{BROWSE}##{hint}")
    imgui.same_line()
    pressed = wide_button(f"{confirm}##{hint}")
    return PathInput(value, bool((entered or pressed) and value.strip()), browse)


def checkbox(text: str, value: bool) -> bool:
    """Draw a check box. Returns whether it is checked."""
    checked = imgui.checkbox(text, value)[1]
    add_tooltip(text)
    return checked


def radio_button(text: str, selected: bool, kind: str = "") -> bool:
    """Draw a radio button. Returns whether it was pressed."""
    pressed = imgui.radio_button(text, selected)
    add_tooltip(text, kind)
    return pressed


def button(text: str, width: float = 0.0, kind: str = "") -> bool:
    """Draw a button, as wide as its text for width 0. Returns whether it was pressed."""
    pressed = imgui.button(text, imgui.ImVec2(width, 0))
    add_tooltip(text, kind)
    return pressed


def wide_button(text: str) -> bool:
    """Draw a button over the rest of the row. Returns whether it was pressed."""
    return button(text, -1)


def progress_bar(fraction: float, text: str) -> None:
    """Draw a bar, 0 to 1, over the rest of the row, with a text on it."""
    imgui.progress_bar(fraction, imgui.ImVec2(-1, 0), text)


def heading(text: str) -> None:
    """Draw the heading of a section."""
    imgui.dummy(imgui.ImVec2(0, 2))
    imgui.separator_text(text)
    add_tooltip(text)


def buttons(names: Sequence[str], columns: int, selected: str | None = None, *, kind: str = "") -> str | None:
    """Draw buttons in rows of equal width, the selected one highlighted. Returns the one that was pressed.

    kind : of the controls, for the tooltips of names that have none of their own
    """
    pressed = None
    spacing = imgui.get_style().item_spacing.x
    width = (imgui.get_content_region_avail().x - spacing * (columns - 1)) / columns
    for i, name in enumerate(names):
        if i % columns:
            imgui.same_line()
        with highlighted(name == selected):
            if button(name, width, kind):
                pressed = name
    return pressed


@contextmanager
def highlighted(on: bool) -> Iterator[None]:
    """Draw the buttons inside in the colour of a selected one if `on`."""
    if on:
        imgui.push_style_color(imgui.Col_.button, imgui.ImVec4(*SELECTED))
        imgui.push_style_color(imgui.Col_.button_hovered, imgui.ImVec4(*SELECTED_HOVERED))
    yield
    if on:
        imgui.pop_style_color(2)


def _button_width(text: str) -> float:
    return imgui.calc_text_size(text).x + 2 * imgui.get_style().frame_padding.x
