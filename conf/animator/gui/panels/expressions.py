"""The emotions panel: expressions as buttons, their envelope, action units as sliders."""

import math
from dataclasses import replace
from pathlib import Path

from imgui_bundle import imgui

from conf.animator.controller import Controller
from conf.animator.gui.widgets import WIDE_LABEL_WIDTH, buttons, checkbox, heading, path_field, slider, wide_button
from conf.face.animation.action_units import ACTION_UNIT_NAMES

MAX_SECONDS = 5.0
MAX_INTENSITY = 1.5


def draw_expressions(controller: Controller, now: float) -> None:
    expression = controller.state.expression
    heading("emotions")
    pressed = buttons(controller.expressions.names, 3, expression.active(now), kind="emotion")
    envelope = expression.envelope
    limits = (0.0, MAX_SECONDS)
    envelope = replace(
        envelope,
        intensity=slider("intensity", envelope.intensity, (0.0, MAX_INTENSITY)),
        onset=slider("onset, s", envelope.onset, limits),
        hold=slider("hold, s", envelope.hold if math.isfinite(envelope.hold) else MAX_SECONDS, limits),
        release=slider("release, s", envelope.release, limits),
    )
    hold_until_released = checkbox("hold until released", expression.hold_until_released)
    imgui.same_line(imgui.get_window_width() * 0.64)
    if wide_button("Release"):
        expression = expression.release(now)
    idle = checkbox("idle motion: blinks, glances, sway", expression.idle)
    expression = replace(expression, envelope=envelope, hold_until_released=hold_until_released, idle=idle)
    epc = path_field("EPC file", controller.state.fields.expressions, "Open")
    heading("action units")
    for unit, name in ACTION_UNIT_NAMES.items():
        before = expression.units.get(unit, 0.0)
        after = slider(f"{unit} {name}", before, (0.0, 1.0), label_width=WIDE_LABEL_WIDTH, kind="action unit")
        if after != before:
            expression = expression.set_unit(unit, after)
    if wide_button("Set all to zero"):
        expression = replace(expression, units={})
    fields = replace(controller.state.fields, expressions=epc.text)
    controller.state = replace(controller.state, expression=expression, fields=fields)
    if pressed:
        controller.play_expression(pressed, now)
    if epc.browse:
        controller.choose_file("expressions")
    if epc.confirmed:
        controller.open_file(Path(epc.text), now)
