"""The muscles' panel: how far each of Waters' muscles contracts."""

from dataclasses import replace

from conf.animator.commands import Request
from conf.animator.gui.widgets import buttons, check, heading, quiet, slider, strength
from conf.animator.state.editor import Desk, Facts
from conf.animator.state.muscles import MAX_JAW, MOST, MUSCLES, POSES, sides_of

LABELS = {"l": "left", "r": "right"}


def draw_muscles(desk: Desk, facts: Facts) -> tuple[Desk, list[Request]]:
    """Draw the panel's tab."""
    muscling = desk.muscling
    heading("Waters' muscles")
    if facts.subject.points is None:
        quiet("Muscles are placed from the control points: place these first.")
        return desk, []
    muscling = replace(muscling, active=check("muscles move the face", muscling.active))
    pose = buttons(tuple(POSES), 2)
    if pose:
        muscling = muscling.posed(pose)
    heading("contraction")
    muscling = replace(muscling, both=check("both sides together", muscling.both))
    for stem in MUSCLES:
        names = sides_of(stem)[:1] if muscling.both else sides_of(stem)
        for name in names:
            before = muscling.contractions.get(name, 0.0)
            text = stem.replace("_", " ") if len(names) == 1 else f"{stem.replace('_', ' ')} {name[-1]}"
            after = strength(text, before, most=MOST)
            if after != before:
                muscling = replace(muscling.contract(name, after), active=True)
    jaw = slider("jaw, rad", muscling.jaw, (0.0, MAX_JAW))
    if jaw != muscling.jaw:
        muscling = replace(muscling, jaw=jaw, active=True)
    return replace(desk, muscling=muscling), []
