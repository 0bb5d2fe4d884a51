"""The start window: its frame loop."""

import time
from datetime import datetime

from imgui_bundle import imgui

from conf.render.ui.imgui_input import ImGuiInput
from conf.render.ui.imgui_overlay import ImGuiOverlay
from conf.render.ui.theme import BACKDROP, themed
from conf.render.window import Window
from conf.render.window.input_events import KeyPressed
from conf.start.controller import StartController
from conf.start.gui.layout import SCALE, Layout
from conf.start.gui.main import StartGui

FPS = 30.0


class StartApp:
    """One window and its controller."""

    def __init__(self, window: Window, controller: StartController) -> None:
        window.close_on_escape = False
        self._window = window
        self._controller = controller
        self._overlay = ImGuiOverlay(window.ctx)
        self._overlay.connect_clipboard(window)
        imgui.get_io().config_flags |= imgui.ConfigFlags_.nav_enable_keyboard
        self._gui = StartGui(window.ctx, self._overlay)
        self._input = ImGuiInput()

    def run(self) -> None:
        """Draw until the window is closed."""
        while not self._window.should_close:
            start = time.monotonic()
            self.step(start)
            time.sleep(max(0.0, start + 1 / FPS - time.monotonic()))

    def step(self, now: float) -> None:
        """Process events; draw one frame unless a call's window has taken the place of this one. now : s"""
        window, controller = self._window, self._controller
        events = window.poll()
        self._input.process_events(events)
        is_typing = imgui.is_any_item_active() or imgui.is_popup_open("", imgui.PopupFlags_.any_popup)
        if KeyPressed("escape") in events and not is_typing:
            self._on_escape()
        controller.update()
        if window.visible == controller.is_connected:
            window.visible = not controller.is_connected
        if controller.is_connected:
            return
        self._gui.prepare(controller)
        window.begin(BACKDROP)
        scale = SCALE.scale(window.size, window.pixel_ratio)
        layout = Layout.of(window.size, scale)
        with self._overlay.frame(window, scale=scale), themed(scale):
            copied = self._gui.draw(controller, layout, now, datetime.now().astimezone())
        if copied is not None:
            window.clipboard = copied
        window.end()

    def close(self) -> None:
        """Free everything."""
        self._gui.release()
        self._overlay.release()

    def _on_escape(self) -> None:
        controller = self._controller
        if controller.state.page != "home":
            controller.hang_up()
        elif controller.state.complains:
            controller.state = controller.state.without_complaints()
        else:
            self._window.should_close = True
