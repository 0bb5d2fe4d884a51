"""Rows of a panel: a label left, what can be worked right of it."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager

from imgui_bundle import imgui

from conf.animator.gui.theme import AMBER, CHOSEN, CHOSEN_HOVERED
from conf.render.ui.imgui_overlay import MUTED

LABEL_SHARE = 0.40  # of a row
LONG_LABEL_SHARE = 0.58


def label(text: str, share: float = LABEL_SHARE) -> None:
    """Write a row's label and make room for the rest of the row."""
    imgui.align_text_to_frame_padding()
    imgui.text(text)
    imgui.same_line(imgui.get_window_width() * share)
    imgui.set_next_item_width(-1)


def slider(text: str, value: float, limits: tuple[float, float], *, number_format: str = "%.2f") -> float:
    """Show a slider. Returns the value, within the limits if it was changed."""
    label(text)
    return _slide(text, value, limits, number_format, imgui.SliderFlags_.always_clamp)


def log_slider(text: str, value: float, limits: tuple[float, float], *, number_format: str = "%.2f") -> float:
    """Show a slider whose steps grow with the value."""
    label(text)
    return _slide(text, value, limits, number_format, imgui.SliderFlags_.always_clamp | imgui.SliderFlags_.logarithmic)


def amount_slider(text: str, value: float, *, maximum: float = 1.0) -> float:
    """Show a slider from 0 with room for a long label."""
    label(text, LONG_LABEL_SHARE)
    return _slide(text, value, (0.0, maximum), "%.2f", imgui.SliderFlags_.always_clamp)


def _slide(text: str, value: float, limits: tuple[float, float], number_format: str, flags: int) -> float:
    changed, moved = imgui.slider_float(f"##{text}", value, *limits, number_format, flags)
    return moved if changed else value


def combo_box(text: str, value: str, names: Sequence[str]) -> str:
    """Show a list to choose from. Returns the chosen name."""
    label(text)
    known = list(names)
    _, index = imgui.combo(f"##{text}", known.index(value) if value in known else 0, known)
    return known[index]


def field(text: str, value: str) -> str:
    """Show a line of text that can be edited: a click chooses all of it. Returns what stands in it."""
    label(text)
    return imgui.input_text(f"##{text}", value, imgui.InputTextFlags_.auto_select_all)[1]


def path_field(hint: str, value: str, button: str) -> tuple[str, bool]:
    """Show a field for a file's name with a button; a click chooses all of it.

    Returns what stands in it, and whether it was sent off.
    """
    wide = imgui.calc_text_size(button).x + 4 * imgui.get_style().frame_padding.x
    imgui.set_next_item_width(-wide)
    flags = imgui.InputTextFlags_.enter_returns_true | imgui.InputTextFlags_.elide_left
    entered, value = imgui.input_text_with_hint(f"##{hint}", hint, value, flags | imgui.InputTextFlags_.auto_select_all)
    imgui.same_line()
    pressed = imgui.button(f"{button}##{hint}", imgui.ImVec2(-1, 0))
    return value, bool((entered or pressed) and value.strip())


def checkbox(text: str, value: bool) -> bool:
    """Show a box to tick. Returns whether it is ticked."""
    return imgui.checkbox(text, value)[1]


def heading(text: str) -> None:
    """Write the name of a part of a panel."""
    imgui.dummy(imgui.ImVec2(0, 2))
    imgui.separator_text(text)


def hint(text: str) -> None:
    """Write a remark, in as many lines as it takes."""
    _wrapped(text, MUTED)


def warning(text: str) -> None:
    """Write what the user should know, in as many lines as it takes."""
    _wrapped(text, AMBER)


def buttons(names: Sequence[str], columns: int, chosen: str | None = None) -> str | None:
    """Show buttons in rows of equal widths, the chosen one lit. Returns the one that was pressed."""
    pressed = None
    space = imgui.get_style().item_spacing.x
    width = (imgui.get_content_region_avail().x - space * (columns - 1)) / columns
    for i, name in enumerate(names):
        if i % columns:
            imgui.same_line()
        with highlighted(name == chosen):
            if imgui.button(name, imgui.ImVec2(width, 0)):
                pressed = name
    return pressed


@contextmanager
def highlighted(on: bool) -> Iterator[None]:
    """Draw buttons inside as chosen ones, if they are."""
    if on:
        imgui.push_style_color(imgui.Col_.button, imgui.ImVec4(*CHOSEN))
        imgui.push_style_color(imgui.Col_.button_hovered, imgui.ImVec4(*CHOSEN_HOVERED))
    yield
    if on:
        imgui.pop_style_color(2)


def _wrapped(text: str, colour: tuple[float, float, float, float]) -> None:
    imgui.push_style_color(imgui.Col_.text, imgui.ImVec4(*colour))
    imgui.push_text_wrap_pos(0.0)
    imgui.text_unformatted(text)
    imgui.pop_text_wrap_pos()
    imgui.pop_style_color()
