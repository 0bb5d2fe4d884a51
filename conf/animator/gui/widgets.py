"""Widgets of a panel: one row each, the label left of it."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager

from imgui_bundle import imgui

from conf.animator.gui.theme import AMBER, SELECTED, SELECTED_HOVERED
from conf.render.ui.imgui_overlay import MUTED

LABEL_WIDTH = 0.40  # of a row
WIDE_LABEL_WIDTH = 0.58


def label(text: str, width: float = LABEL_WIDTH) -> None:
    """Draw the label of a row; the next widget fills the rest."""
    imgui.align_text_to_frame_padding()
    imgui.text(text)
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
) -> float:
    """Draw a slider. Returns the value, clamped to the limits only if the user changed it."""
    label(text, label_width)
    flags = imgui.SliderFlags_.always_clamp | (imgui.SliderFlags_.logarithmic if logarithmic else 0)
    changed, new = imgui.slider_float(f"##{text}", value, *limits, number_format, flags)
    return new if changed else value


def combo_box(text: str, value: str, names: Sequence[str]) -> str:
    """Draw a drop-down list. Returns the selected name; the first if `value` is not in the list."""
    label(text)
    names = list(names)
    _, index = imgui.combo(f"##{text}", names.index(value) if value in names else 0, names)
    return names[index]


def text_field(text: str, value: str) -> str:
    """Draw a text field; a click selects all of its text. Returns the text."""
    label(text)
    return imgui.input_text(f"##{text}", value, imgui.InputTextFlags_.auto_select_all)[1]


def path_field(hint: str, value: str, button: str) -> tuple[str, bool]:
    """Draw a text field for a file name, with a button; a click selects all of its text.

    Returns the text, and whether a text was confirmed with Enter or the button.
    """
    button_width = imgui.calc_text_size(button).x + 4 * imgui.get_style().frame_padding.x
    imgui.set_next_item_width(-button_width)
    flags = imgui.InputTextFlags_.enter_returns_true | imgui.InputTextFlags_.elide_left
    entered, value = imgui.input_text_with_hint(f"##{hint}", hint, value, flags | imgui.InputTextFlags_.auto_select_all)
    imgui.same_line()
    pressed = wide_button(f"{button}##{hint}")
    return value, bool((entered or pressed) and value.strip())


def checkbox(text: str, value: bool) -> bool:
    """Draw a check box. Returns whether it is checked."""
    return imgui.checkbox(text, value)[1]


def wide_button(text: str) -> bool:
    """Draw a button over the rest of the row. Returns whether it was pressed."""
    return imgui.button(text, imgui.ImVec2(-1, 0))


def heading(text: str) -> None:
    """Draw the heading of a section."""
    imgui.dummy(imgui.ImVec2(0, 2))
    imgui.separator_text(text)


def hint(text: str) -> None:
    """Draw wrapped text in a muted colour."""
    _draw_wrapped(text, MUTED)


def warning(text: str) -> None:
    """Draw wrapped text in a warning colour."""
    _draw_wrapped(text, AMBER)


def buttons(names: Sequence[str], columns: int, selected: str | None = None) -> str | None:
    """Draw buttons in rows of equal width, the selected one highlighted. Returns the one that was pressed."""
    pressed = None
    spacing = imgui.get_style().item_spacing.x
    width = (imgui.get_content_region_avail().x - spacing * (columns - 1)) / columns
    for i, name in enumerate(names):
        if i % columns:
            imgui.same_line()
        with highlighted(name == selected):
            if imgui.button(name, imgui.ImVec2(width, 0)):
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


def _draw_wrapped(text: str, colour: tuple[float, float, float, float]) -> None:
    imgui.push_style_color(imgui.Col_.text, imgui.ImVec4(*colour))
    imgui.push_text_wrap_pos(0.0)
    imgui.text_unformatted(text)
    imgui.pop_text_wrap_pos()
    imgui.pop_style_color()
