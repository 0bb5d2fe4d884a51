"""The face's panel: files, and placing the control points."""

from dataclasses import replace
from pathlib import Path

from imgui_bundle import imgui

from conf.animator.commands import (
    ApplyPoints,
    CancelPlacement,
    FitPoints,
    MirrorPoints,
    OpenFile,
    PlacePoints,
    Request,
    SavePoints,
    SetAxes,
)
from conf.animator.gui.widgets import buttons, checkbox, combo_box, heading, hint, path_field, warning
from conf.animator.state.editor import EditorState, StatusInfo
from conf.animator.state.point_placement import PointPlacement, swapped_pairs
from conf.face.control_points import CONTROL_POINT_COUNT, CONTROL_POINTS
from conf.face.mesh.axes import AXES


def draw_face(desk: EditorState, facts: StatusInfo) -> tuple[EditorState, list[Request]]:
    """Draw the panel's tab."""
    if desk.placing is not None:
        return _draw_placing(desk, desk.placing)
    requests: list[Request] = []
    fields = desk.fields
    heading("face")
    mesh = facts.subject.mesh
    imgui.text(facts.subject.path.name)
    hint(f"{len(mesh.vertices):,} vertices, {len(mesh.triangles):,} triangles")
    face, go = path_field("OBJ, PLY, GLB or STL file", fields.face, "Open")
    if go:
        requests.append(OpenFile(Path(face)))
    heading("control points")
    if facts.subject.points is None:
        warning("This face has no control points yet: let them be found, place them by hand, or load a PPC file.")
        requests += _draw_axes(facts.subject.axes)
    else:
        hint(f"{CONTROL_POINT_COUNT} points move this face.")
    if facts.fitting is not None:
        hint(f"Finding the points: {facts.fitting} ...")
    elif facts.can_fit and not facts.subject.is_default and imgui.button("Find points", imgui.ImVec2(-1, 0)):
        requests.append(FitPoints())
    if imgui.button("Place points ...", imgui.ImVec2(-1, 0)):
        requests.append(PlacePoints())
    points, go = path_field("PPC file", fields.points, "Load")
    if go:
        requests.append(OpenFile(Path(points)))
    if imgui.button("Save PPC", imgui.ImVec2(-1, 0)):
        requests.append(SavePoints(Path(points.strip() or facts.subject.path.with_suffix(".ppc").name)))
    hint("Files can also be dropped onto the window.")
    return replace(desk, fields=replace(fields, face=face, points=points)), requests


def _draw_axes(axes: tuple[str, str]) -> list[Request]:
    """Let the user say how the mesh stands in its file."""
    up = combo_box("crown towards", axes[0], list(AXES))
    front = combo_box("nose towards", axes[1], [axis for axis in AXES if axis[-1] != up[-1]])
    return [SetAxes(up, front)] if (up, front) != axes else []


def _draw_placing(desk: EditorState, placing: PointPlacement) -> tuple[EditorState, list[Request]]:
    requests: list[Request] = []
    heading("place the control points")
    point = CONTROL_POINTS[placing.selected]
    imgui.text(f"{point.index}  {point.name.replace('_', ' ')}")
    hint(f"MPEG-4 {point.feature_point}. Click its place on the face; drag a point to correct it.")
    imgui.progress_bar(
        1 - placing.missing / CONTROL_POINT_COUNT,
        imgui.ImVec2(-1, 0),
        f"{CONTROL_POINT_COUNT - placing.missing} of {CONTROL_POINT_COUNT}",
    )
    placing = replace(placing, mirror=checkbox("a point takes its partner along", placing.mirror))
    pressed = buttons(("Left to right", "Undo"), 2)
    if pressed == "Left to right":
        requests.append(MirrorPoints())
    if pressed == "Undo":
        placing = placing.undo()
    imgui.begin_disabled(placing.missing > 0)
    if imgui.button("OK", imgui.ImVec2(-1, 0)):
        requests.append(ApplyPoints())
    imgui.end_disabled()
    if imgui.button("Cancel", imgui.ImVec2(-1, 0)):
        requests.append(CancelPlacement())
    if placing.missing:
        hint(f"OK comes when the {placing.missing} points left have their places.")
    for left, right in swapped_pairs(placing)[:3]:
        warning(f"{left} should lie to the right of {right} in this picture: are they exchanged?")
    hint("Pick points on the reference face below; left and right are the subject's.")
    return replace(desk, placing=placing), requests
