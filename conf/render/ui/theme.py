"""Colours and sizes of windows with controls, and the columns that hold them."""

from collections.abc import Iterator
from contextlib import contextmanager

from imgui_bundle import imgui, imgui_ctx

from conf.render.ui.imgui_overlay import ACCENT, MUTED, TEXT
from conf.render.ui.rectangle import Rect

BACKDROP = (0.052, 0.060, 0.076, 1.0)
RAISED = (0.118, 0.138, 0.170, 1.0)
HOVERED = (0.160, 0.190, 0.235, 1.0)
SELECTED = (0.125, 0.330, 0.450, 1.0)
SELECTED_HOVERED = (0.150, 0.400, 0.540, 1.0)
AMBER = (1.0, 0.76, 0.36, 1.0)
GREEN = (0.45, 0.86, 0.55, 1.0)
COLOURS = {
    imgui.Col_.window_bg: (0.0, 0.0, 0.0, 0.0),  # transparent: the window is cleared to BACKDROP
    imgui.Col_.popup_bg: (0.075, 0.088, 0.110, 0.98),
    imgui.Col_.text: TEXT,
    imgui.Col_.text_disabled: MUTED,
    imgui.Col_.frame_bg: RAISED,
    imgui.Col_.frame_bg_hovered: HOVERED,
    imgui.Col_.frame_bg_active: HOVERED,
    imgui.Col_.slider_grab: (*ACCENT[:3], 0.5),
    imgui.Col_.slider_grab_active: (*ACCENT[:3], 0.8),
    imgui.Col_.check_mark: ACCENT,
    imgui.Col_.button: RAISED,
    imgui.Col_.button_hovered: HOVERED,
    imgui.Col_.button_active: SELECTED,
    imgui.Col_.header: SELECTED,
    imgui.Col_.header_hovered: HOVERED,
    imgui.Col_.header_active: SELECTED,
    imgui.Col_.tab: BACKDROP,
    imgui.Col_.tab_hovered: SELECTED_HOVERED,
    imgui.Col_.tab_selected: SELECTED,
    imgui.Col_.tab_selected_overline: ACCENT,
    imgui.Col_.plot_histogram: (*ACCENT[:3], 0.8),
    imgui.Col_.separator: HOVERED,
    imgui.Col_.scrollbar_bg: BACKDROP,
    imgui.Col_.border: HOVERED,
    imgui.Col_.modal_window_dim_bg: (0.0, 0.0, 0.0, 0.45),
}
SIZES: dict[imgui.StyleVar_, tuple[float, float] | float] = {  # pixels at scale 1
    imgui.StyleVar_.frame_rounding: 3.0,
    imgui.StyleVar_.grab_rounding: 3.0,
    imgui.StyleVar_.frame_padding: (6.0, 2.5),
    imgui.StyleVar_.item_spacing: (6.0, 4.0),
    imgui.StyleVar_.item_inner_spacing: (6.0, 4.0),
    imgui.StyleVar_.window_rounding: 0.0,
    imgui.StyleVar_.window_padding: (10.0, 8.0),
    imgui.StyleVar_.grab_min_size: 9.0,
    imgui.StyleVar_.scrollbar_size: 9.0,
}
COLUMN_FLAGS = (
    imgui.WindowFlags_.no_title_bar
    | imgui.WindowFlags_.no_resize
    | imgui.WindowFlags_.no_move
    | imgui.WindowFlags_.no_collapse
    | imgui.WindowFlags_.no_saved_settings
    | imgui.WindowFlags_.no_bring_to_front_on_focus
)


@contextmanager
def themed(scale: float) -> Iterator[None]:
    """Apply the theme to everything drawn inside."""
    for name, colour in COLOURS.items():
        imgui.push_style_color(name, imgui.ImVec4(*colour))
    for variable, size in SIZES.items():
        if isinstance(size, float):
            imgui.push_style_var(variable, size * scale)
        else:
            imgui.push_style_var(variable, imgui.ImVec2(size[0] * scale, size[1] * scale))
    try:
        yield
    finally:
        imgui.pop_style_var(len(SIZES))
        imgui.pop_style_color(len(COLOURS))


@contextmanager
def column(name: str, rect: Rect, flags: int = 0) -> Iterator[None]:
    """Open an ImGui window that fills a rectangle."""
    imgui.set_next_window_pos(imgui.ImVec2(rect.x, rect.y))
    imgui.set_next_window_size(imgui.ImVec2(rect.width, rect.height))
    with imgui_ctx.begin(name, None, COLUMN_FLAGS | flags):
        yield
