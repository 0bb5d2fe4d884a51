"""The view's panel: style, light, background, direction."""

import math
from dataclasses import replace

from imgui_bundle import imgui

from conf.animator.commands import Request
from conf.animator.gui.influence_colours import REGIONS
from conf.animator.gui.widgets import buttons, checkbox, combo_box, heading, hint
from conf.animator.state.editor import EditorState, StatusInfo
from conf.animator.state.view_settings import STYLES
from conf.face.control_points import CONTROL_POINTS
from conf.render.lighting import LIGHTS
from conf.render.render_target import BACKDROPS, SOLID_COLOURS

ALL = "all regions"
ANGLES = {"front": 0.0, "half left": math.pi / 5, "half right": -math.pi / 5, "left": math.pi / 2,
          "right": -math.pi / 2, "behind": math.pi}  # fmt: skip


def draw_view(desk: EditorState, facts: StatusInfo) -> tuple[EditorState, list[Request]]:
    """Draw the panel's tab."""
    look = desk.look
    heading("style")
    style = buttons(STYLES, 3, look.style)
    look = replace(look, style=style or look.style)
    look = replace(look, view=replace(look.view, points=checkbox("control points", look.view.points)))
    look = replace(look, eye_contact=checkbox("eye contact: the eyes look at you", look.eye_contact))
    heading("light and background")
    look = replace(look, lights=combo_box("light", look.lights, list(LIGHTS)))
    look = replace(look, background=combo_box("background", look.background, [*BACKDROPS, *SOLID_COLOURS]))
    heading("direction")
    angle = buttons(tuple(ANGLES), 3)
    if angle:
        look = replace(look, view=replace(look.view, yaw=ANGLES[angle], pitch=0.0))
    if imgui.button("Reset turn, place and zoom", imgui.ImVec2(-1, 0)):
        look = replace(look, view=look.view.reset())
    hint("Drag turns, shift and drag moves, the wheel zooms.")
    if look.style == "regions":
        names = [ALL, *(f"{p.index} {p.name.replace('_', ' ')}" for p in CONTROL_POINTS)]
        heading("influence")
        chosen = combo_box("of", names[0 if look.influence is None else look.influence + 1], names)
        look = replace(look, influence=None if chosen == ALL else int(chosen.split()[0]))
        if look.influence is None:
            _draw_legend()
        if facts.subject.points is None:
            hint("Regions show when the control points are placed.")
    return replace(desk, look=look), []


def _draw_legend() -> None:
    for i, (name, (_, colour)) in enumerate(REGIONS.items()):
        if i % 2:
            imgui.same_line(imgui.get_window_width() * 0.5)
        shade = imgui.ImVec4(colour[0] / 255, colour[1] / 255, colour[2] / 255, 1.0)
        side = imgui.get_text_line_height() * 0.8
        imgui.color_button(f"##{name}", shade, imgui.ColorEditFlags_.no_tooltip, imgui.ImVec2(side, side))
        imgui.same_line()
        imgui.text(name)
