"""The muscles panel: contractions of Waters' muscles and the jaw."""

from dataclasses import replace

from conf.animator.controller import Controller
from conf.animator.gui.widgets import WIDE_LABEL_WIDTH, buttons, checkbox, heading, hint, slider
from conf.animator.state.muscles import MAX_CONTRACTION, MAX_JAW, MUSCLES, PRESETS, muscle_names


def draw_muscles(controller: Controller, _now: float) -> None:
    """Draw the panel."""
    muscles = controller.state.muscles
    heading("Waters' muscles")
    if controller.face.document.points is None:
        hint("Muscles need control points: place these first.")
        return
    muscles = replace(muscles, active=checkbox("muscles move the face", muscles.active))
    preset = buttons(tuple(PRESETS), 2)
    if preset:
        muscles = muscles.with_preset(preset)
    heading("contraction")
    muscles = replace(muscles, symmetric=checkbox("both sides together", muscles.symmetric))
    for stem in MUSCLES:
        names = muscle_names(stem)[:1] if muscles.symmetric else muscle_names(stem)
        for name in names:
            text = stem.replace("_", " ") + (f" {name[-1]}" if len(names) > 1 else "")
            before = muscles.contractions.get(name, 0.0)
            after = slider(text, before, (0.0, MAX_CONTRACTION), label_width=WIDE_LABEL_WIDTH)
            if after != before:
                muscles = replace(muscles.contract(name, after), active=True)
    jaw = slider("jaw, rad", muscles.jaw, (0.0, MAX_JAW))
    if jaw != muscles.jaw:
        muscles = replace(muscles, jaw=jaw, active=True)
    controller.state = replace(controller.state, muscles=muscles)
