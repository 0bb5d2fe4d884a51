"""The deformer's panel: radial basis functions and what they depend on, changed while the face moves."""

from dataclasses import replace

from imgui_bundle import imgui

from conf.animator.commands import Request
from conf.animator.gui.widgets import checkbox, combo_box, heading, hint, log_slider, warning
from conf.animator.state.editor import EditorState, StatusInfo
from conf.face.deformation.face_model import DeformerOptions
from conf.face.deformation.kernels import KERNELS

POLYNOMIALS = {"kernel's own": None, "none": -1, "constant": 0, "linear": 1}
EPSILONS = (0.05, 8.0)  # 1/cm
LAMBDAS = (0.0, 10.0)


def draw_deformer(desk: EditorState, facts: StatusInfo) -> tuple[EditorState, list[Request]]:
    """Draw the panel's tab."""
    deformer, muscling = desk.deformer, desk.muscling
    heading("what moves the skin")
    if imgui.radio_button("radial basis functions", not muscling.active):
        muscling = replace(muscling, active=False)
    if imgui.radio_button("Waters' muscles", muscling.active):
        muscling = replace(muscling, active=True)
    imgui.begin_disabled(muscling.active)
    heading("kernel")
    for name in KERNELS:
        if imgui.radio_button(name, deformer.kernel == name) and deformer.kernel != name:
            deformer = replace(deformer, kernel=name, epsilon=None)
    own = KERNELS[deformer.kernel].epsilon
    epsilon = log_slider("locality, 1/cm", deformer.epsilon or own, EPSILONS)
    deformer = replace(deformer, epsilon=None if epsilon == own else epsilon)
    inverse = {degree: name for name, degree in POLYNOMIALS.items()}
    deformer = replace(
        deformer, degree=POLYNOMIALS[combo_box("polynomial", inverse[deformer.degree], list(POLYNOMIALS))]
    )
    deformer = replace(deformer, smoothing=log_slider("lambda", deformer.smoothing, LAMBDAS, number_format="%.5f"))
    heading("regions of influence")
    deformer = replace(deformer, use_regions=checkbox("lips and lids apart", deformer.use_regions))
    if facts.subject.shapes is not None:
        deformer = replace(
            deformer, use_ridge_refinement=checkbox("refined on sculpted shapes", deformer.use_ridge_refinement)
        )
    if imgui.button("Back to the defaults", imgui.ImVec2(-1, 0)):
        deformer = DeformerOptions()
    imgui.end_disabled()
    _draw_operator(facts, deformer)
    return replace(desk, deformer=deformer, muscling=muscling), []


def _draw_operator(facts: StatusInfo, deformer: DeformerOptions) -> None:
    heading("operator B")
    if facts.subject.points is None:
        hint("There is none before the control points are placed.")
        return
    state = "building ..." if facts.busy else f"built in {facts.build_ms:.0f} ms"
    hint(f"{facts.vertices:,} x 50, {state}")
    if facts.smoothing > deformer.smoothing and not facts.busy:
        warning(f"The system was singular: lambda was raised to {facts.smoothing:.2g} by itself.")
