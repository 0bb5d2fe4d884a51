"""The view panel: style, lights, background, direction, influence."""

import math
from dataclasses import replace

from imgui_bundle import imgui

from conf.animator.controller import Controller
from conf.animator.gui.influence_colours import REGIONS
from conf.animator.gui.widgets import buttons, checkbox, combo_box, heading, wide_button
from conf.animator.state.editor import STYLES
from conf.face.control_points import CONTROL_POINTS
from conf.render.lighting import LIGHTS
from conf.render.render_target import BACKDROPS, SOLID_COLOURS
from conf.render.ui.wrapped_text import hint

ALL_REGIONS = "all regions"
YAWS = {"front": 0.0, "half left": math.pi / 5, "half right": -math.pi / 5, "left": math.pi / 2,
        "right": -math.pi / 2, "behind": math.pi}  # fmt: skip


def draw_view(controller: Controller, _now: float) -> None:
    view, camera = controller.state.view, controller.state.view.camera
    heading("style")
    style = buttons(STYLES, 3, view.style, kind="style") or view.style
    camera = replace(camera, points=checkbox("control points", camera.points))
    eye_contact = checkbox("eye contact: the eyes look at you", view.eye_contact)
    heading("light and background")
    lights = combo_box("light", view.lights, list(LIGHTS))
    background = combo_box("background", view.background, [*BACKDROPS, *SOLID_COLOURS])
    heading("direction")
    direction = buttons(tuple(YAWS), 3, kind="direction")
    if direction:
        camera = replace(camera, yaw=YAWS[direction], pitch=0.0)
    if wide_button("Reset rotation, position and zoom"):
        camera = camera.reset()
    hint("Drag to rotate, shift and drag to move, scroll to zoom.")
    influence = view.influence
    if style == "regions":
        heading("influence")
        names = [ALL_REGIONS, *(f"{p.index} {p.name.replace('_', ' ')}" for p in CONTROL_POINTS)]
        name = combo_box("of", names[0 if influence is None else influence + 1], names)
        influence = None if name == ALL_REGIONS else int(name.split()[0])
        if influence is None:
            _draw_legend()
        if controller.face.document.points is None:
            hint("Place the control points to see the regions.")
    view = replace(
        view,
        camera=camera,
        style=style,
        influence=influence,
        lights=lights,
        background=background,
        eye_contact=eye_contact,
    )
    controller.state = replace(controller.state, view=view)


def _draw_legend() -> None:
    side = imgui.get_text_line_height() * 0.8
    for i, (name, (_, (red, green, blue))) in enumerate(REGIONS.items()):
        if i % 2:
            imgui.same_line(imgui.get_window_width() * 0.5)
        colour = imgui.ImVec4(red / 255, green / 255, blue / 255, 1.0)
        imgui.color_button(f"##{name}", colour, imgui.ColorEditFlags_.no_tooltip, imgui.ImVec2(side, side))
        imgui.same_line()
        imgui.text(name)
