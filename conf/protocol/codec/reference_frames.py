"""Quantised frames, and the memory of them that each side predicts later frames from."""

from collections.abc import Iterable
from dataclasses import dataclass, field
from itertools import takewhile

from conf.errors import ProtocolError
from conf.protocol.codec.reconstruction import HISTORY

POSE_VALUES = 6
LOG_SCALE, ROTATION, FACE_CENTRE = 0, slice(1, 4), slice(4, 6)
MAX_AGE = 63  # ticks between a frame and its reference
MAX_TICKS = 2 * MAX_AGE  # twice what may be referred to, because datagrams arrive out of order

PointResidual = tuple[int, int, int]


@dataclass(frozen=True)
class QuantisedFrame:
    """One coded frame, in steps of its profile: integers, equal on every machine.

    values : log scale, rotation (3), face centre (2), then the components of the learned space
    residuals : by point, x, y, z that the learned space cannot represent
    staggered : some values count from half a step further, see transform.py
    """

    values: tuple[int, ...]
    staggered: bool = False
    residuals: dict[int, PointResidual] = field(default_factory=dict)


class MissingReferenceError(ProtocolError):
    """A frame is predicted from a frame that was never received: request frames without prediction."""


class ReferenceFrames:
    """The frames of one profile by number, up to MAX_TICKS behind the newest."""

    def __init__(self) -> None:
        self.newest = -1  # the greatest number so far
        self._frames: dict[int, QuantisedFrame] = {}

    def add(self, frame_number: int, frame: QuantisedFrame) -> None:
        """Store a frame; drop those that are too old."""
        self.newest = max(self.newest, frame_number)
        self._frames[frame_number] = frame
        for old in [n for n in self._frames if n < self.newest - MAX_TICKS]:
            del self._frames[old]

    def numbers(self) -> Iterable[int]:
        """Return the numbers of all stored frames."""
        return self._frames.keys()

    def get(self, frame_number: int) -> QuantisedFrame | None:
        """Return the frame, or None if it is not stored."""
        return self._frames.get(frame_number)

    def before(self, frame_number: int, stride: int) -> list[QuantisedFrame]:
        """Return the frames one, two, ... strides earlier that a frame is shown with, up to the first not stored."""
        numbers = (frame_number - age * stride for age in range(1, HISTORY + 1))
        known = takewhile(lambda frame: frame is not None, map(self.get, numbers))
        return [frame for frame in known if frame is not None]

    def require(self, frame_number: int) -> QuantisedFrame:
        """Return the frame. Raises MissingReferenceError if it is not stored."""
        frame = self._frames.get(frame_number)
        if frame is None:
            raise MissingReferenceError(f"frame {frame_number} is the reference and is not known")
        return frame
