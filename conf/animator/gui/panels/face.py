"""The face panel: files, and placing the control points."""

from dataclasses import replace
from pathlib import Path

from imgui_bundle import imgui

from conf.animator.controller import Controller
from conf.animator.gui.widgets import buttons, checkbox, combo_box, heading, path_field, progress_bar, wide_button
from conf.animator.state.point_placement import PointPlacement
from conf.face.control_points import CONTROL_POINT_COUNT, CONTROL_POINTS
from conf.face.mesh.axes import AXES
from conf.render.ui.wrapped_text import hint, warning

MAX_WARNINGS = 3


def draw_face(controller: Controller, now: float) -> None:
    if controller.state.placement is not None:
        _draw_placement(controller, controller.state.placement)
        return
    fields, document = controller.state.fields, controller.face.document
    heading("face")
    imgui.text(document.path.name)
    hint(f"{len(document.mesh.vertices):,} vertices, {len(document.mesh.triangles):,} triangles")
    face = path_field("mesh file", fields.face, "Open")
    heading("control points")
    if document.points is None:
        warning("This face has no control points yet: find them, place them by hand, or load a PPC file.")
        _draw_axes(controller)
    else:
        hint(f"{CONTROL_POINT_COUNT} points move this face.")
    progress = controller.fitting.progress
    if progress is not None:
        progress_bar(progress.fraction, f"finding the points, {100 * progress.fraction:.0f} %")
        hint(progress.text)
    elif controller.fitting.available and not document.is_default and wide_button("Find points"):
        controller.find_points()
    if wide_button("Place points ..."):
        controller.place_points()
    points = path_field("PPC file", fields.points, "Load")
    pressed = buttons(("Save PPC", "Save as ..."), 2)
    hint("Files can also be dropped onto the window.")
    controller.state = replace(controller.state, fields=replace(fields, face=face.text, points=points.text))
    if pressed == "Save PPC":
        controller.save_points(controller.points_path)
    elif pressed:
        controller.choose_file("saved points")
    for name, field in (("face", face), ("points", points)):
        if field.browse:
            controller.choose_file(name)
        if field.confirmed:
            controller.open_file(Path(field.text), now)


def _draw_axes(controller: Controller) -> None:
    """Draw the lists of the file's up and front axes."""
    axes = controller.face.document.axes
    up = combo_box("up axis", axes[0], list(AXES))
    front = combo_box("front axis", axes[1], [axis for axis in AXES if axis[-1] != up[-1]])
    if (up, front) != axes:
        controller.set_axes(up, front)


def _draw_placement(controller: Controller, placement: PointPlacement) -> None:
    heading("place the control points")
    point = CONTROL_POINTS[placement.selected]
    imgui.text(f"{point.index}  {point.name.replace('_', ' ')}")
    hint(f"MPEG-4 {point.feature_point}. Click its position on the face; drag a point to correct it.")
    placed = CONTROL_POINT_COUNT - placement.missing
    text = f"{placed} of {CONTROL_POINT_COUNT}"
    progress_bar(placed / CONTROL_POINT_COUNT, text)
    placement = replace(placement, mirror=checkbox("also place the mirrored point", placement.mirror))
    pressed = buttons(("Left to right", "Undo"), 2)
    if pressed == "Undo":
        placement = placement.undo()
    controller.state = replace(controller.state, placement=placement)
    if pressed == "Left to right":
        controller.mirror_points()
    imgui.begin_disabled(placement.missing > 0)
    if wide_button("OK"):
        controller.apply_points()
    imgui.end_disabled()
    if wide_button("Cancel"):
        controller.cancel_placement()
    if placement.missing:
        hint(f"OK is available when the {placement.missing} missing points are placed.")
    for left, right in placement.swapped_pairs[:MAX_WARNINGS]:
        warning(f"{left} should lie to the right of {right} in this image: are they swapped?")
    hint("Select points on the reference face below; left and right are the subject's.")
