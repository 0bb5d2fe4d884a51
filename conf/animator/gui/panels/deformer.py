"""The deformer panel, for radial basis functions, and the panel of Waters' muscles."""

from dataclasses import replace

from imgui_bundle import imgui

from conf.animator.controller import Controller
from conf.animator.gui.widgets import (
    WIDE_LABEL_WIDTH,
    buttons,
    checkbox,
    combo_box,
    heading,
    radio_button,
    slider,
    wide_button,
)
from conf.animator.state.editor import MAX_CONTRACTION, MAX_JAW, MUSCLES, PRESETS, muscle_names
from conf.face.deformation.face_model import DeformerOptions
from conf.face.deformation.rbf import KERNELS
from conf.render.ui.wrapped_text import hint, warning

POLYNOMIALS = {"kernel's own": None, "none": -1, "constant": 0, "linear": 1}
EPSILON_LIMITS = (0.05, 8.0)  # 1/cm
LAMBDA_LIMITS = (0.0, 10.0)


def draw_deformer(controller: Controller, _now: float) -> None:
    deformer, muscles = controller.state.deformer, controller.state.muscles
    heading("deformation by")
    if radio_button("radial basis functions", not muscles.active):
        muscles = replace(muscles, active=False)
    if radio_button("Waters' muscles", muscles.active):
        muscles = replace(muscles, active=True)
    imgui.begin_disabled(muscles.active)
    heading("kernel")
    for name in KERNELS:
        if radio_button(name, deformer.kernel == name, "kernel") and deformer.kernel != name:
            deformer = replace(deformer, kernel=name, epsilon=None)
    default = KERNELS[deformer.kernel].epsilon
    epsilon = slider("locality, 1/cm", deformer.epsilon or default, EPSILON_LIMITS, logarithmic=True)
    names = {degree: name for name, degree in POLYNOMIALS.items()}
    degree = POLYNOMIALS[combo_box("polynomial", names[deformer.degree], list(POLYNOMIALS))]
    smoothing = slider("lambda", deformer.smoothing, LAMBDA_LIMITS, number_format="%.5f", logarithmic=True)
    heading("regions of influence")
    use_regions = checkbox("separate lips and eyelids", deformer.use_regions)
    use_ridge_refinement = deformer.use_ridge_refinement
    if controller.face.document.shapes is not None:
        use_ridge_refinement = checkbox("refine with blendshapes", use_ridge_refinement)
    deformer = replace(
        deformer,
        epsilon=None if epsilon == default else epsilon,
        degree=degree,
        smoothing=smoothing,
        use_regions=use_regions,
        use_ridge_refinement=use_ridge_refinement,
    )
    if wide_button("Reset to defaults"):
        deformer = DeformerOptions()
    imgui.end_disabled()
    controller.state = replace(controller.state, deformer=deformer, muscles=muscles)
    _draw_operator(controller)


def _draw_operator(controller: Controller) -> None:
    heading("operator B")
    face = controller.face
    if face.document.points is None:
        hint("Not built: place the control points first.")
        return
    build = "building ..." if face.busy else f"built in {face.build_ms:.0f} ms"
    hint(f"{len(face.model.mesh.vertices):,} x 50, {build}")
    if face.model.smoothing > controller.state.deformer.smoothing and not face.busy:
        warning(f"The system was singular: lambda was raised to {face.model.smoothing:.2g}.")


def draw_muscles(controller: Controller, _now: float) -> None:
    muscles = controller.state.muscles
    heading("Waters' muscles")
    if controller.face.document.points is None:
        hint("Muscles need control points: place these first.")
        return
    muscles = replace(muscles, active=checkbox("muscles move the face", muscles.active))
    preset = buttons(tuple(PRESETS), 2, kind="preset")
    if preset:
        muscles = muscles.with_preset(preset)
    heading("contraction")
    muscles = replace(muscles, symmetric=checkbox("both sides together", muscles.symmetric))
    for stem in MUSCLES:
        names = muscle_names(stem)[:1] if muscles.symmetric else muscle_names(stem)
        for name in names:
            text = stem.replace("_", " ") + (f" {name[-1]}" if len(names) > 1 else "")
            before = muscles.contractions.get(name, 0.0)
            after = slider(text, before, (0.0, MAX_CONTRACTION), label_width=WIDE_LABEL_WIDTH, kind="muscle")
            if after != before:
                muscles = replace(muscles.contract(name, after), active=True)
    jaw = slider("jaw, rad", muscles.jaw, (0.0, MAX_JAW))
    if jaw != muscles.jaw:
        muscles = replace(muscles, jaw=jaw, active=True)
    controller.state = replace(controller.state, muscles=muscles)
