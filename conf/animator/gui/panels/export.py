"""The export's panel: what goes into which file."""

from dataclasses import replace
from pathlib import Path

from imgui_bundle import imgui

from conf.animator.commands import CancelExport, Export, Request
from conf.animator.file_export import WRITERS
from conf.animator.gui.widgets import combo_box, field, heading, hint
from conf.animator.state.editor import CURRENT_VIEW, RECORDING, EditorState, StatusInfo

KINDS = {
    ".jpg": "picture, JPEG",
    ".png": "picture, PNG",
    ".avi": "clip, AVI",
    ".mp4": "clip, MP4",
    ".obj": "moved mesh, OBJ",
    ".ppc": "control points, PPC",
    ".dpc": "motion, DPC",
    ".fap": "motion, MPEG-4 FAP",
    ".csv": "52 shapes, CSV",
}


def draw_export(desk: EditorState, facts: StatusInfo) -> tuple[EditorState, list[Request]]:
    """Draw the panel's tab."""
    requests: list[Request] = []
    fields = desk.fields
    heading("what")
    sources = [CURRENT_VIEW, *([RECORDING] if facts.player else []), *facts.emotions.names]
    fields = replace(fields, source=combo_box("source", fields.source, sources))
    suffix = Path(fields.output).suffix.lower()
    known = {suffix: text for suffix, text in KINDS.items() if suffix in WRITERS}
    kind = combo_box("kind", known.get(suffix, ""), list(known.values()))
    picked = next(s for s, text in known.items() if text == kind)
    if picked != suffix and suffix in known:
        fields = replace(fields, output=str(Path(fields.output or "face").with_suffix(picked)))
    fields = replace(fields, output=field("file", fields.output))
    if suffix in (".jpg", ".png", ".avi", ".mp4"):
        fields = replace(fields, size=field("size, px", fields.size))
    if suffix in (".avi", ".mp4", ".dpc", ".fap", ".csv"):
        fields = replace(fields, fps=field("frames a s", fields.fps))
    if facts.progress is None:
        if imgui.button("Export##button", imgui.ImVec2(-1, 0)):
            requests.append(Export())
    else:
        imgui.progress_bar(facts.progress, imgui.ImVec2(-1, 0), f"{100 * facts.progress:.0f} %")
        if imgui.button("Cancel export", imgui.ImVec2(-1, 0)):
            requests.append(CancelExport())
    hint("Pictures and clips look as the view does: style, turn, zoom. S saves a picture, R records what you see.")
    return replace(desk, fields=fields), requests
