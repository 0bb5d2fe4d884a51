"""The page while a call is prepared: the code to tell the other one, or whom is called."""

from __future__ import annotations

from imgui_bundle import imgui

from conf.protocol.address import typed_address
from conf.render.ui.imgui_overlay import ACCENT, MUTED, TEXT, ImGuiOverlay
from conf.render.ui.wrapped_text import hint
from conf.start.controller import StartController
from conf.start.gui.widgets import button, centred_text
from conf.start.state import CallTarget, StartState

CODE_EMS = 3.0  # text height of the code, in text heights
WIDTH_EMS = 34.0  # of the page's content, at most
COPIED_S = 2.0
COPIED = "copied"
NO_NETWORK = "This machine is in no network: only programs on it can call, at 127.0.0.1."
OUTSIDE = (
    "From outside of your network the other one needs the address of your router, which must forward UDP port {port} "
    "to this machine."
)
OVER_RELAY = "The other one needs the same relay in its window: {relay}"
IN_NETWORK = "The other one must be in the same network, or both name a relay."
OPENING = "looking for a free number ..."
OWN_WINDOW = "The call has its own window."


class WaitingPanel:
    """Draws the page, and remembers what was copied."""

    def __init__(self) -> None:
        self._copied = ""
        self._copied_at = 0.0

    def draw(self, controller: StartController, overlay: ImGuiOverlay, now: float) -> str | None:
        """Draw the page. Returns a text to copy to the clipboard. now : s"""
        state, copied = controller.state, None
        target = state.target
        if target is None:
            return None
        width = min(imgui.get_content_region_avail().x, WIDTH_EMS * imgui.get_font_size())
        imgui.set_cursor_pos_x((imgui.get_window_width() - width) / 2)
        imgui.begin_child("waiting", imgui.ImVec2(width, 0), imgui.ChildFlags_.nav_flattened)
        if target.is_waiting and target.code and not state.connected:
            copied = self._draw_code(target, overlay, now)
            if target.relay is None:
                copied = copied or self._draw_addresses(controller, target, now)
            else:
                imgui.dummy(imgui.ImVec2(0, imgui.get_font_size()))
                hint(OVER_RELAY.format(relay=target.relay) if target.relay else IN_NETWORK)
        else:
            imgui.dummy(imgui.ImVec2(0, 3 * imgui.get_font_size()))
        _draw_progress(controller, state, target)
        imgui.dummy(imgui.ImVec2(0, imgui.get_font_size()))
        text = "Hang up" if state.connected else "Stop waiting" if target.is_waiting else "Cancel"
        if button(text, -1):
            controller.hang_up()
        imgui.end_child()
        if copied is not None:
            self._copied, self._copied_at = copied, now
        return copied

    def _draw_code(self, target: CallTarget, overlay: ImGuiOverlay, now: float) -> str | None:
        imgui.dummy(imgui.ImVec2(0, 0.5 * imgui.get_font_size()))
        centred_text("The one who calls you types this code:", MUTED)
        size = CODE_EMS * imgui.get_font_size()
        imgui.push_font(overlay.bold, size / imgui.get_style().font_scale_main)
        fitting = imgui.get_content_region_avail().x / max(1.0, imgui.calc_text_size(target.code).x)
        imgui.pop_font()
        imgui.push_font(overlay.bold, min(1.0, fitting) * size / imgui.get_style().font_scale_main)
        centred_text(target.code, ACCENT)
        imgui.pop_font()
        pressed = button(self._copy_label("Copy the code", target.code, now), -1, is_main=True)
        return target.code if pressed else None

    def _draw_addresses(self, controller: StartController, target: CallTarget, now: float) -> str | None:
        imgui.dummy(imgui.ImVec2(0, imgui.get_font_size()))
        if controller.addresses is None:
            return None
        if not controller.addresses:
            hint(NO_NETWORK)
            return None
        centred_text("and one of these addresses:" if len(controller.addresses) > 1 else "and this address:", MUTED)
        copied = None
        for address in controller.addresses:
            text = typed_address(address, target.port)
            imgui.align_text_to_frame_padding()
            imgui.text_colored(imgui.ImVec4(*TEXT), text)
            imgui.same_line(imgui.get_content_region_avail().x - 5 * imgui.get_font_size())
            if button(self._copy_label("Copy", text, now), 5 * imgui.get_font_size()):
                copied = text
        hint(OUTSIDE.format(port=target.port))
        return copied

    def _copy_label(self, text: str, value: str, now: float) -> str:
        """Return the label of the button that copies a value, whose identity for ImGui stays the same."""
        is_copied = self._copied == value and now < self._copied_at + COPIED_S
        return f"{COPIED if is_copied else text}###{value}"


def _draw_progress(controller: StartController, state: StartState, target: CallTarget) -> None:
    """Draw what is being done, and the call's last message."""
    imgui.dummy(imgui.ImVec2(0, imgui.get_font_size()))
    if state.connected:
        centred_text(OWN_WINDOW, TEXT)
    elif target.is_waiting:
        centred_text("waiting for a call ..." if target.code else OPENING, TEXT)
    else:
        centred_text(f"calling {target.address} ...", TEXT)
    if controller.messages and not (target.code and target.code in controller.messages[-1]):  # the code is above
        hint(controller.messages[-1])
