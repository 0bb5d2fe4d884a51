"""What the panels ask for that is not a change of their own state: files, the clock, the worker."""

from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Open:
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
class Stand:
    """Stand a face without control points upright: its file's axes towards crown and nose."""

    up: str
    front: str


@dataclass(frozen=True)
class MirrorPoints:
    """Take every placed point of the left side over to the right."""


@dataclass(frozen=True)
class AcceptPoints:
    """The points are placed: build the face on them."""


@dataclass(frozen=True)
class LeavePlacing:
    """Stop placing and keep the points as they were."""


@dataclass(frozen=True)
class Play:
    """Begin an emotion."""

    name: str


@dataclass(frozen=True)
class Release:
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
class Step:
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
class RecordTake:
    """Begin to take down what the face does, or end it: the take becomes the recording."""


@dataclass(frozen=True)
class WriteFile:
    """Export what is chosen in the export panel."""


@dataclass(frozen=True)
class CancelExport:
    """Leave the export that is under way."""


Request = (
    Open
    | SavePoints
    | PlacePoints
    | FitPoints
    | Stand
    | MirrorPoints
    | AcceptPoints
    | LeavePlacing
    | Play
    | Release
    | TogglePlaying
    | Stop
    | Seek
    | Step
    | SetSpeed
    | SetLoop
    | CloseRecording
    | RecordTake
    | WriteFile
    | CancelExport
)
