"""The emotions' panel: emotions as buttons, action units as sliders."""

import math
from dataclasses import replace
from pathlib import Path

from imgui_bundle import imgui

from conf.animator.commands import Open, Play, Release, Request
from conf.animator.gui.widgets import buttons, check, heading, path_field, slider, strength
from conf.animator.state.editor import Desk, Facts
from conf.face.animation.action_units import NAMES

MOST_SECONDS = 5.0


def draw_emotions(desk: Desk, facts: Facts) -> tuple[Desk, list[Request]]:
    """Draw the panel's tab."""
    requests: list[Request] = []
    expressing = desk.expressing
    heading("emotions")
    pressed = buttons(facts.emotions.names, 3, expressing.active(facts.now))
    if pressed:
        requests.append(Play(pressed))
    envelope = expressing.envelope
    envelope = replace(
        envelope,
        intensity=slider("intensity", envelope.intensity, (0.0, 1.5)),
        onset=slider("onset, s", envelope.onset, (0.0, MOST_SECONDS)),
        hold=slider("hold, s", envelope.hold if math.isfinite(envelope.hold) else MOST_SECONDS, (0.0, MOST_SECONDS)),
        release=slider("release, s", envelope.release, (0.0, MOST_SECONDS)),
    )
    stays = check("stays until released", expressing.stays)
    imgui.same_line(imgui.get_window_width() * 0.64)
    if imgui.button("Release", imgui.ImVec2(-1, 0)):
        requests.append(Release())
    idle = check("idle life: blinks, glances, sways", expressing.idle)
    expressing = replace(expressing, envelope=envelope, stays=stays, idle=idle)
    epc, go = path_field("EPC file of your own", desk.fields.expressions, "Open")
    if go:
        requests.append(Open(Path(epc)))
    heading("action units")
    for unit, name in NAMES.items():
        before = expressing.units.get(unit, 0.0)
        after = strength(f"{unit} {name}", before)
        if after != before:
            expressing = expressing.set_unit(unit, after)
    if imgui.button("All to zero", imgui.ImVec2(-1, 0)):
        expressing = replace(expressing, units={})
    return replace(desk, expressing=expressing, fields=replace(desk.fields, expressions=epc)), requests
