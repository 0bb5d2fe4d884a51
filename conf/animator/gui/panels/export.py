"""The export panel: source, format and file."""

from dataclasses import replace
from pathlib import Path

from conf.animator.controller import Controller
from conf.animator.file_export import MOTIONS, needs_drawing
from conf.animator.gui.widgets import combo_box, heading, output_field, progress_bar, text_field, wide_button
from conf.animator.keys import key_label
from conf.animator.state.editor import CURRENT_VIEW, RECORDING
from conf.output.clip_encoder import CLIP_FORMATS
from conf.render.ui.wrapped_text import hint

FORMATS = {
    ".jpg": "image, JPEG",
    ".png": "image, PNG",
    ".mp4": "clip, MP4",
    ".avi": "clip, AVI",
    ".obj": "deformed mesh, OBJ",
    ".ppc": "control points, PPC",
    ".dpc": "motion, DPC",
    ".fap": "motion, MPEG-4 FAP",
    ".csv": "52 blendshapes, CSV",
}


def draw_export(controller: Controller, _now: float) -> None:
    fields = controller.state.fields
    heading("export")
    recording = [RECORDING] if controller.player else []
    sources = [CURRENT_VIEW, *recording, *controller.expressions.names]
    fields = replace(fields, source=combo_box("source", fields.source, sources))
    suffix = Path(fields.output).suffix.lower()
    name = combo_box("format", FORMATS.get(suffix, ""), list(FORMATS.values()))
    selected = next(suffix for suffix, text in FORMATS.items() if text == name)
    if selected != suffix and suffix in FORMATS:
        fields = replace(fields, output=str(Path(fields.output).with_suffix(selected)))
    output, browse = output_field("file", fields.output)
    fields = replace(fields, output=output)
    if needs_drawing(Path(fields.output)):
        fields = replace(fields, size=text_field("size, px", fields.size))
    if suffix in (*CLIP_FORMATS, *MOTIONS):
        fields = replace(fields, fps=text_field("frames/s", fields.fps))
    controller.state = replace(controller.state, fields=fields)
    if browse:
        controller.choose_file("output")
    progress = controller.export_progress
    if progress is None:
        if wide_button("Export##button"):
            controller.export()
    else:
        progress_bar(progress, f"{100 * progress:.0f} %")
        if wide_button("Cancel export"):
            controller.cancel_export()
    keys = f"{key_label('screenshot')} saves the current view, {key_label('record')} records the face."
    hint(f"Images and clips use the settings of the view. {keys}")
