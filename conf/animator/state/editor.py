"""Immutable editor state: everything the user has chosen. Every change makes a new object."""

from dataclasses import dataclass, field

from conf.animator.state.expression import ExpressionState
from conf.animator.state.muscles import MuscleState
from conf.animator.state.point_placement import PointPlacement
from conf.face.deformation.face_model import DeformerOptions
from conf.render.camera import ViewState

STYLES = ("rendered", "wireframe", "regions")
CURRENT_VIEW = "current view"  # export sources, beside the names of the expressions
RECORDING = "recording"


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
    """The state of all panels. placement : None unless control points are being placed."""

    view: ViewSettings = field(default_factory=ViewSettings)
    deformer: DeformerOptions = field(default_factory=DeformerOptions)
    expression: ExpressionState = field(default_factory=ExpressionState)
    muscles: MuscleState = field(default_factory=MuscleState)
    placement: PointPlacement | None = None
    fields: TextFields = field(default_factory=TextFields)
    show_help: bool = False
