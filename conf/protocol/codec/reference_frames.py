"""The frames of one profile that either side still remembers, by number: what later ones may be predicted from."""

from collections.abc import Iterable

from conf.errors import ProtocolError
from conf.protocol.codec.model import MAX_AGE
from conf.protocol.codec.quantised_frame import QuantisedFrame

MAX_TICKS = 2 * MAX_AGE  # ticks: twice what may be referred to, because datagrams overtake each other


class MissingReferenceError(ProtocolError):
    """A frame is predicted from one that was never received here: ask for frames without prediction."""

    def __init__(self, number: int) -> None:
        super().__init__(f"frame {number} is the reference and is not known")
        self.number = number


class ReferenceFrames:
    """A bounded memory of frames by number."""

    def __init__(self) -> None:
        self.newest = -1  # the greatest number so far
        self._frames: dict[int, QuantisedFrame] = {}

    def add(self, number: int, frame: QuantisedFrame) -> None:
        """Keep a frame; forget those that are too old to be referred to."""
        self.newest = max(self.newest, number)
        self._frames[number] = frame
        for old in [n for n in self._frames if n < self.newest - MAX_TICKS]:
            del self._frames[old]

    def numbers(self) -> Iterable[int]:
        """Return the numbers of all frames that are known."""
        return self._frames.keys()

    def get(self, number: int) -> QuantisedFrame | None:
        """Return the frame if it is known."""
        return self._frames.get(number)

    def require(self, number: int) -> QuantisedFrame:
        """Return the frame. Raises MissingReferenceError if it is not known."""
        found = self._frames.get(number)
        if found is None:
            raise MissingReferenceError(number)
        return found
