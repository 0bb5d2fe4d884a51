"""Immutable editor state: everything the user has chosen. Every change makes a new object."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Literal

from conf.animator.state.point_placement import PointPlacement
from conf.face.animation.expression_state import ExpressionState
from conf.face.deformation.face_model import DeformerOptions
from conf.face.deformation.facial_muscles import MUSCLE_COURSES, SPHINCTER
from conf.face.symmetry import OTHER_SIDE
from conf.render.camera import ViewState

STYLES = ("rendered", "wireframe", "regions")
CURRENT_VIEW = "current view"  # export sources, beside the names of the expressions
RECORDING = "recording"
Question = Literal["quit", "cancel"]

MUSCLES = (*MUSCLE_COURSES, SPHINCTER)
MAX_JAW = 0.45  # rad
MAX_CONTRACTION = 0.5  # stronger contractions tear the mesh

# Contractions and jaw angle, rad. Smile and open mouth: figures 4.6 and 4.11 of the thesis.
PRESETS: dict[str, tuple[dict[str, float], float]] = {
    "relaxed": ({}, 0.0),
    "smile": ({"zygomatic_major": 0.25}, 0.0),
    "open mouth": ({"depressor_labii": 0.12, "levator_labii": 0.03}, 0.18),
    "frown": ({"depressor_anguli": 0.18, "corrugator": 0.25, "frontalis_inner": 0.12}, 0.0),
    "raised brows": ({"frontalis_inner": 0.3, "frontalis_outer": 0.3}, 0.0),
    "kiss": ({SPHINCTER: 0.4}, 0.0),
}


def muscle_names(stem: str) -> tuple[str, ...]:
    """Return the names of a pair of muscles, left first, or of the one in the middle."""
    return (stem,) if stem == SPHINCTER else (f"{stem}_l", f"{stem}_r")


@dataclass(frozen=True)
class MuscleState:
    """Immutable muscle state.

    active : whether muscles deform the face instead of radial basis functions
    contractions : muscle -> 0 relaxed to 1
    jaw : rad
    symmetric : whether a slider changes both sides
    """

    active: bool = False
    contractions: Mapping[str, float] = field(default_factory=dict)
    jaw: float = 0.0
    symmetric: bool = True

    def contract(self, muscle: str, contraction: float) -> "MuscleState":
        """Set the contraction of a muscle, and of its partner if `symmetric`."""
        stem, _, side = muscle.rpartition("_")
        names = muscle_names(stem) if self.symmetric and side in OTHER_SIDE else (muscle,)
        return replace(self, contractions={**self.contractions, **dict.fromkeys(names, contraction)})

    def with_preset(self, preset: str) -> "MuscleState":
        """Set all contractions and the jaw to those of a preset, and let muscles deform the face."""
        by_stem, jaw = PRESETS[preset]
        contractions = {name: contraction for stem, contraction in by_stem.items() for name in muscle_names(stem)}
        return replace(self, contractions=contractions, jaw=jaw, active=True)


@dataclass(frozen=True)
class ViewSettings:
    """How the face is drawn.

    camera : orbit, zoom and pan
    influence : control point whose influence alone is coloured in the style "regions", None for all
    lights, background : a key of LIGHTS; a key of BACKDROPS or SOLID_COLOURS
    eye_contact : whether the eyes look at the viewer
    """

    camera: ViewState = field(default_factory=lambda: ViewState(stats=False))
    style: str = "rendered"
    influence: int | None = None
    lights: str = "studio"
    background: str = "wall"
    eye_contact: bool = False


@dataclass(frozen=True)
class TextFields:
    """Contents of the text fields, and the export source."""

    face: str = ""
    points: str = ""
    recording: str = ""
    expressions: str = ""
    output: str = "face.jpg"
    source: str = CURRENT_VIEW
    size: str = "1280x720"
    fps: str = "30"


@dataclass(frozen=True)
class EditorState:
    """The state of all panels.

    placement : None unless control points are being placed
    question : what the user is asked before placed points are lost, None for no question
    """

    view: ViewSettings = field(default_factory=ViewSettings)
    deformer: DeformerOptions = field(default_factory=DeformerOptions)
    expression: ExpressionState = field(default_factory=ExpressionState)
    muscles: MuscleState = field(default_factory=MuscleState)
    placement: PointPlacement | None = None
    question: Question | None = None
    fields: TextFields = field(default_factory=TextFields)
    show_help: bool = False
