"""Everything that the start window draws."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from datetime import datetime

import moderngl
from imgui_bundle import imgui, imgui_ctx

from conf.render.gpu_object import GpuObject
from conf.render.ui.imgui_overlay import ACCENT, MUTED, TITLE_PX, ImGuiOverlay
from conf.render.ui.rectangle import Rect
from conf.render.ui.theme import AMBER, column
from conf.start.controller import StartController
from conf.start.gui.call_panel import draw_call_panel
from conf.start.gui.device_panel import draw_device_panel
from conf.start.gui.layout import Layout
from conf.start.gui.picture import CameraPicture
from conf.start.gui.waiting_panel import WaitingPanel
from conf.start.gui.widgets import button, show_tooltip

SUBTITLE = "a video conference for links that cannot carry video"
FRAME_PADDING_PX = (8.0, 4.5)  # of controls, at scale 1: larger than in the animator, which has many more


class StartGui(GpuObject):
    """Draws the window's pages."""

    def __init__(self, ctx: moderngl.Context, overlay: ImGuiOverlay) -> None:
        self._overlay = overlay
        self._picture = CameraPicture(ctx)
        self._waiting = WaitingPanel()
        self._owned = (self._picture,)

    def prepare(self, controller: StartController) -> None:
        """Copy images to the graphics card. To be called outside of `overlay.frame`."""
        self._picture.prepare(controller.camera)

    def draw(self, controller: StartController, layout: Layout, now: float, local_time: datetime) -> str | None:
        """Draw one frame. To be called inside `overlay.frame`. Returns a text to copy to the clipboard.

        now : s; local_time : in the local time zone
        """
        scale = self._overlay.scale
        with imgui_ctx.push_style_var(imgui.StyleVar_.frame_padding, imgui.ImVec2(*FRAME_PADDING_PX) * scale):
            # each page has its own name: otherwise ImGui looks for the control that the keyboard had reached before
            with column(controller.state.page, layout.window, imgui.WindowFlags_.no_scrollbar):
                return self._draw_page(controller, layout, now, local_time)

    def _draw_page(self, controller: StartController, layout: Layout, now: float, local_time: datetime) -> str | None:
        copied = None
        with part("header", layout.header, imgui.WindowFlags_.no_scrollbar):
            self._draw_header()
        if controller.state.page == "home":
            with part("call", layout.left):
                draw_call_panel(controller, local_time)
            with part("devices", layout.right):
                draw_device_panel(controller, self._overlay, self._picture)
        else:
            with part("page", layout.page):
                copied = self._waiting.draw(controller, self._overlay, now)
        with part("footer", layout.footer, imgui.WindowFlags_.no_scrollbar):
            _draw_footer(controller)
        return copied

    def _draw_header(self) -> None:
        imgui.push_font(self._overlay.bold, TITLE_PX)
        imgui.text_colored(imgui.ImVec4(*ACCENT), "conf")
        height = imgui.get_font_size()
        imgui.pop_font()
        imgui.same_line()
        imgui.set_cursor_pos_y(imgui.get_cursor_pos_y() + 0.75 * (height - imgui.get_font_size()))
        imgui.text_colored(imgui.ImVec4(*MUTED), SUBTITLE)


@contextmanager
def part(name: str, rect: Rect, flags: int = 0) -> Iterator[None]:
    """Open a part of the window. The Tab key goes through all parts, in the order in which they are drawn."""
    imgui.set_cursor_screen_pos(imgui.ImVec2(rect.x, rect.y))
    child_flags = imgui.ChildFlags_.nav_flattened | imgui.ChildFlags_.always_use_window_padding
    with imgui_ctx.begin_child(name, imgui.ImVec2(rect.width, rect.height), child_flags, flags):
        yield


def _draw_footer(controller: StartController) -> None:
    """Draw the way to the animator, and what has to be said about the last call or the settings."""
    if controller.state.page == "home":
        if button("Animate a face"):
            controller.animate()
        imgui.same_line()
    notice = controller.state.notice
    if notice:
        _draw_notice(notice)


def _draw_notice(text: str) -> None:
    """Draw a text in two lines at most, in the middle of the row; the whole of it while the mouse rests there."""
    wrap, line = imgui.get_content_region_avail().x, imgui.get_font_size()
    height = imgui.calc_text_size(text, wrap_width=wrap).y
    shown = min(height, 2 * line)
    top = imgui.get_window_pos().y + (imgui.get_window_height() - shown) / 2
    corner = imgui.ImVec2(imgui.get_cursor_screen_pos().x, top)
    imgui.dummy(imgui.ImVec2(wrap, imgui.get_frame_height()))
    if height > shown:
        show_tooltip(text)
    draw_list, colour = imgui.get_window_draw_list(), imgui.get_color_u32(imgui.ImVec4(*AMBER))
    draw_list.push_clip_rect(corner, imgui.ImVec2(corner.x + wrap, top + shown), True)
    draw_list.add_text(imgui.get_font(), line, corner, colour, text, wrap_width=wrap)
    draw_list.pop_clip_rect()
