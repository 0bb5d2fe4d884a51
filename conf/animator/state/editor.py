"""All that the animator's user has chosen, as plain data; and what the panels are told beside it."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from conf.animator.face_document import FaceDocument
from conf.animator.motion_player import MotionPlayer
from conf.animator.state.expression import ExpressionState
from conf.animator.state.muscles import MuscleState
from conf.animator.state.point_placement import PointPlacement
from conf.animator.state.view_settings import ViewSettings
from conf.face.deformation.face_model import DeformerOptions
from conf.face.formats.epc import ExpressionSet

CURRENT_VIEW = "what is shown"
RECORDING = "the recording"


@dataclass(frozen=True)
class TextFields:
    """What stands in the text fields."""

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
    """The state of every panel. Every change gives a new one."""

    look: ViewSettings = field(default_factory=ViewSettings)
    deformer: DeformerOptions = field(default_factory=DeformerOptions)
    expressing: ExpressionState = field(default_factory=ExpressionState)
    muscling: MuscleState = field(default_factory=MuscleState)
    placing: PointPlacement | None = None
    fields: TextFields = field(default_factory=TextFields)
    help: bool = False


@dataclass(frozen=True)
class StatusInfo:
    """What the panels show and cannot change.

    now : seconds, on the clock of the loop
    smoothing : the lambda that operator B took; build_ms : the time it took; busy : whether another is being built
    emotions : every expression that can be played
    taking : whether a take is being recorded
    fits : whether control points can be looked for; fitting : how far that is, None if it is not under way
    progress : of an export under way, 0 to 1
    """

    now: float
    subject: FaceDocument
    player: MotionPlayer | None
    emotions: ExpressionSet
    smoothing: float = 0.0
    build_ms: float = 0.0
    busy: bool = False
    recording: bool = False
    can_fit: bool = False
    fitting: str | None = None
    progress: float | None = None
    fps: float = 0.0
    vertices: int = 0
    units: Mapping[int, str] = field(default_factory=dict)
