"""Left column: call, be called, recent calls."""

from datetime import datetime

from imgui_bundle import imgui

from conf.render.ui.wrapped_text import hint
from conf.start.controller import StartController
from conf.start.gui.widgets import FieldInput, button, draw_error, heading, row_button, text_field
from conf.start.recent_calls import describe_time

ADDRESS_HINT = "HOST or HOST:PORT"
NO_ADDRESS_HINT = "not needed with this code"
CODE_HINT = "4711-acorn-tulip-river"
RELAY_HINT = "HOST; none is needed in one network"
WAIT_AT_PORT = "Wait at this port"
PORT_EMS = 4.0  # width of the field, in text heights
NO_CALLS = "no calls yet"


def draw_call_panel(controller: StartController, now: datetime) -> None:
    """Draw the column. now : in the local time zone"""
    heading("Call")
    is_wanted = _draw_field(controller, "code", CODE_HINT).entered
    is_wanted |= _draw_address(controller)
    is_wanted |= button("Call", -1, is_main=True)
    heading("Be called")
    is_waiting_wanted = button("Wait for a call", -1, is_main=True)
    is_port_wanted = _draw_port(controller)
    heading("A relay for both")
    _draw_relay(controller)
    heading("Recent calls")
    _draw_recent_calls(controller, now)
    if is_wanted:
        controller.call()
    elif is_waiting_wanted:
        controller.wait_for_call()
    elif is_port_wanted:
        controller.wait_at_port()


def _draw_field(controller: StartController, name: str, hint_text: str) -> FieldInput:
    """Draw a field of the state."""
    state = controller.state
    typed = text_field(name, getattr(state, name), hint=hint_text, error=getattr(state, f"{name}_error"))
    controller.state = controller.state.with_field(name, typed.text)
    return typed


def _draw_address(controller: StartController) -> bool:
    """Draw the address, unless the code needs none. Returns whether Enter was pressed in it."""
    is_needed = controller.state.needs_address
    imgui.begin_disabled(not is_needed)
    typed = text_field(
        "address",
        controller.state.address if is_needed else "",
        hint=ADDRESS_HINT if is_needed else NO_ADDRESS_HINT,
        error=controller.state.address_error if is_needed else "",
    )
    imgui.end_disabled()
    if is_needed:
        controller.state = controller.state.with_field("address", typed.text)
    return typed.entered


def _draw_relay(controller: StartController) -> None:
    typed = _draw_field(controller, "relay", RELAY_HINT)
    if typed.entered or typed.left:
        controller.enter_relay()


def _draw_port(controller: StartController) -> bool:
    """Draw the port with its button beside it. Returns whether to wait there."""
    typed = text_field("port", controller.state.port, width=PORT_EMS * imgui.get_font_size())
    controller.state = controller.state.with_field("port", typed.text)
    imgui.same_line()
    pressed = button(WAIT_AT_PORT, -1)
    if controller.state.port_error:
        draw_error(controller.state.port_error)
    return typed.entered or pressed


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
