"""What the panels ask for that is not a change of their own state: files, the clock, the worker."""

from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class OpenFile:
    """Open a file: a mesh, control points, a recording or expressions, by its suffix."""

    path: Path


@dataclass(frozen=True)
class SavePoints:
    """Write the control points to a PPC file."""

    path: Path


@dataclass(frozen=True)
class PlacePoints:
    """Begin to place the control points by hand."""


@dataclass(frozen=True)
class FitPoints:
    """Look for the control points in the background."""


@dataclass(frozen=True)
class SetAxes:
    """Stand a face without control points upright: its file's axes towards crown and nose."""

    up: str
    front: str


@dataclass(frozen=True)
class MirrorPoints:
    """Take every placed point of the left side over to the right."""


@dataclass(frozen=True)
class ApplyPoints:
    """The points are placed: build the face on them."""


@dataclass(frozen=True)
class CancelPlacement:
    """Stop placing and keep the points as they were."""


@dataclass(frozen=True)
class PlayExpression:
    """Begin an emotion."""

    name: str


@dataclass(frozen=True)
class ReleaseExpressions:
    """Let the emotions fade."""


@dataclass(frozen=True)
class TogglePlaying:
    """Pause the recording, or go on."""


@dataclass(frozen=True)
class Stop:
    """Stand still at the recording's beginning."""


@dataclass(frozen=True)
class Seek:
    """Go to a position in seconds."""

    position: float


@dataclass(frozen=True)
class StepFrames:
    """Stand still so many frames on."""

    frames: int


@dataclass(frozen=True)
class SetSpeed:
    """Play so much faster than recorded."""

    speed: float


@dataclass(frozen=True)
class SetLoop:
    """Begin again at the end, or stop there."""

    loop: bool


@dataclass(frozen=True)
class CloseRecording:
    """Put the recording away."""


@dataclass(frozen=True)
class ToggleMotionRecording:
    """Begin to take down what the face does, or end it: the take becomes the recording."""


@dataclass(frozen=True)
class Export:
    """Export what is chosen in the export panel."""


@dataclass(frozen=True)
class CancelExport:
    """Leave the export that is under way."""


Request = (
    OpenFile
    | SavePoints
    | PlacePoints
    | FitPoints
    | SetAxes
    | MirrorPoints
    | ApplyPoints
    | CancelPlacement
    | PlayExpression
    | ReleaseExpressions
    | TogglePlaying
    | Stop
    | Seek
    | StepFrames
    | SetSpeed
    | SetLoop
    | CloseRecording
    | ToggleMotionRecording
    | Export
    | CancelExport
)
