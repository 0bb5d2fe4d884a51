"""All that the animator's user has chosen, as plain data; and what the panels are told beside it."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from conf.animator.face_document import Subject
from conf.animator.motion_player import Player
from conf.animator.state.expression import Expressing
from conf.animator.state.muscles import Muscling
from conf.animator.state.point_placement import Placing
from conf.animator.state.view_settings import Look
from conf.face.deformation.face_model import Deformer
from conf.face.formats.epc import Expressions

SHOWN = "what is shown"
RECORDING = "the recording"


@dataclass(frozen=True)
class Fields:
    """What stands in the text fields."""

    face: str = ""
    points: str = ""
    recording: str = ""
    expressions: str = ""
    output: str = "face.jpg"
    source: str = SHOWN
    size: str = "1280x720"
    fps: str = "30"


@dataclass(frozen=True)
class Desk:
    """The state of every panel. Every change gives a new one."""

    look: Look = field(default_factory=Look)
    deformer: Deformer = field(default_factory=Deformer)
    expressing: Expressing = field(default_factory=Expressing)
    muscling: Muscling = field(default_factory=Muscling)
    placing: Placing | None = None
    fields: Fields = field(default_factory=Fields)
    help: bool = False


@dataclass(frozen=True)
class Facts:
    """What the panels show and cannot change.

    now : seconds, on the clock of the loop
    smoothing : the lambda that operator B took; build_ms : the time it took; busy : whether another is being built
    emotions : every expression that can be played
    taking : whether a take is being recorded
    fits : whether control points can be looked for; fitting : how far that is, None if it is not under way
    progress : of an export under way, 0 to 1
    """

    now: float
    subject: Subject
    player: Player | None
    emotions: Expressions
    smoothing: float = 0.0
    build_ms: float = 0.0
    busy: bool = False
    taking: bool = False
    fits: bool = False
    fitting: str | None = None
    progress: float | None = None
    fps: float = 0.0
    vertices: int = 0
    units: Mapping[int, str] = field(default_factory=dict)
