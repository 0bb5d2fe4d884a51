"""The emotions' panel: emotions as buttons, action units as sliders."""

import math
from dataclasses import replace
from pathlib import Path

from imgui_bundle import imgui

from conf.animator.commands import OpenFile, PlayExpression, ReleaseExpressions, Request
from conf.animator.gui.widgets import amount_slider, buttons, checkbox, heading, path_field, slider
from conf.animator.state.editor import EditorState, StatusInfo
from conf.face.animation.action_units import ACTION_UNIT_NAMES

MOST_SECONDS = 5.0


def draw_emotions(desk: EditorState, facts: StatusInfo) -> tuple[EditorState, list[Request]]:
    """Draw the panel's tab."""
    requests: list[Request] = []
    expressing = desk.expressing
    heading("emotions")
    pressed = buttons(facts.emotions.names, 3, expressing.active(facts.now))
    if pressed:
        requests.append(PlayExpression(pressed))
    envelope = expressing.envelope
    envelope = replace(
        envelope,
        intensity=slider("intensity", envelope.intensity, (0.0, 1.5)),
        onset=slider("onset, s", envelope.onset, (0.0, MOST_SECONDS)),
        hold=slider("hold, s", envelope.hold if math.isfinite(envelope.hold) else MOST_SECONDS, (0.0, MOST_SECONDS)),
        release=slider("release, s", envelope.release, (0.0, MOST_SECONDS)),
    )
    stays = checkbox("stays until released", expressing.hold_until_released)
    imgui.same_line(imgui.get_window_width() * 0.64)
    if imgui.button("Release", imgui.ImVec2(-1, 0)):
        requests.append(ReleaseExpressions())
    idle = checkbox("idle life: blinks, glances, sways", expressing.idle)
    expressing = replace(expressing, envelope=envelope, hold_until_released=stays, idle=idle)
    epc, go = path_field("EPC file of your own", desk.fields.expressions, "Open")
    if go:
        requests.append(OpenFile(Path(epc)))
    heading("action units")
    for unit, name in ACTION_UNIT_NAMES.items():
        before = expressing.units.get(unit, 0.0)
        after = amount_slider(f"{unit} {name}", before)
        if after != before:
            expressing = expressing.set_unit(unit, after)
    if imgui.button("All to zero", imgui.ImVec2(-1, 0)):
        expressing = replace(expressing, units={})
    return replace(desk, expressing=expressing, fields=replace(desk.fields, expressions=epc)), requests
