"""The muscles' panel: how far each of Waters' muscles contracts."""

from dataclasses import replace

from conf.animator.commands import Request
from conf.animator.gui.widgets import amount_slider, buttons, checkbox, heading, hint, slider
from conf.animator.state.editor import EditorState, StatusInfo
from conf.animator.state.muscles import MAX_CONTRACTION, MAX_JAW, MUSCLES, PRESETS, muscle_names

LABELS = {"l": "left", "r": "right"}


def draw_muscles(desk: EditorState, facts: StatusInfo) -> tuple[EditorState, list[Request]]:
    """Draw the panel's tab."""
    muscling = desk.muscling
    heading("Waters' muscles")
    if facts.subject.points is None:
        hint("Muscles are placed from the control points: place these first.")
        return desk, []
    muscling = replace(muscling, active=checkbox("muscles move the face", muscling.active))
    pose = buttons(tuple(PRESETS), 2)
    if pose:
        muscling = muscling.with_preset(pose)
    heading("contraction")
    muscling = replace(muscling, symmetric=checkbox("both sides together", muscling.symmetric))
    for stem in MUSCLES:
        names = muscle_names(stem)[:1] if muscling.symmetric else muscle_names(stem)
        for name in names:
            before = muscling.contractions.get(name, 0.0)
            text = stem.replace("_", " ") if len(names) == 1 else f"{stem.replace('_', ' ')} {name[-1]}"
            after = amount_slider(text, before, maximum=MAX_CONTRACTION)
            if after != before:
                muscling = replace(muscling.contract(name, after), active=True)
    jaw = slider("jaw, rad", muscling.jaw, (0.0, MAX_JAW))
    if jaw != muscling.jaw:
        muscling = replace(muscling, jaw=jaw, active=True)
    return replace(desk, muscling=muscling), []
