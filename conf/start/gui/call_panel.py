"""Left column: call, be called, recent calls."""

from datetime import datetime

from imgui_bundle import imgui

from conf.render.ui.wrapped_text import hint
from conf.start.controller import StartController
from conf.start.gui.widgets import button, heading, row_button, text_field
from conf.start.recent_calls import describe_time

ADDRESS_HINT = "HOST or HOST:PORT"
CODE_HINT = "acorn-tulip-river-42"
NO_CALLS = "no calls yet"


def draw_call_panel(controller: StartController, now: datetime) -> None:
    """Draw the column. now : in the local time zone"""
    heading("Call")
    is_wanted = _draw_field(controller, "address", ADDRESS_HINT)
    is_wanted |= _draw_field(controller, "code", CODE_HINT)
    is_wanted |= button("Call", -1, is_main=True)
    heading("Be called")
    is_waiting_wanted = _draw_field(controller, "port", "")
    is_waiting_wanted |= button("Wait for a call", -1, is_main=True)
    heading("Recent calls")
    _draw_recent_calls(controller, now)
    if is_wanted:
        controller.call()
    elif is_waiting_wanted:
        controller.wait_for_call()


def _draw_field(controller: StartController, name: str, hint_text: str) -> bool:
    """Draw a field of the state. Returns whether Enter was pressed in it."""
    state = controller.state
    typed = text_field(name, getattr(state, name), hint=hint_text, error=getattr(state, f"{name}_error"))
    controller.state = controller.state.with_field(name, typed.text)
    return typed.entered


def _draw_recent_calls(controller: StartController, now: datetime) -> None:
    if not controller.recent:
        hint(NO_CALLS)
        return
    below = imgui.get_frame_height_with_spacing()
    if imgui.begin_child("recent calls", imgui.ImVec2(0, -below), imgui.ChildFlags_.nav_flattened):
        for number, call in enumerate(controller.recent):
            text = f"{call.name}  {call.address}" if call.name and call.address else call.name or call.address
            tooltip = "recent call" if call.address else "received call"
            if row_button(text, describe_time(call.time, now), f"call {number}", tooltip) and call.address:
                controller.choose_recent(call)
    imgui.end_child()
    if button("Clear"):
        controller.clear_recent()
