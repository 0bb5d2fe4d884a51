"""The head of a payload: which profile, how many frames, how far apart, predicted from what.

The tables are fixed and lean towards the usual case, which costs under a bit beside the age of the reference.
"""

from dataclasses import dataclass

from conf.protocol.codec.model import MAX_AGE
from conf.protocol.codec.profiles import PROFILES, Profile
from conf.protocol.codec.symbol_coder import SymbolCoder, SymbolReader, weighted_table

MAX_FRAMES = 8
MAX_STRIDE = 4

_NAMES = tuple(PROFILES)
_PROFILE = weighted_table([30, 2, 2])
_COUNT = {
    name: weighted_table([300 if count == profile.frames_per_datagram else 1 for count in range(1, MAX_FRAMES + 1)])
    for name, profile in PROFILES.items()
}
_STRIDE = weighted_table([300, 3, 1, 1])
_AGE = weighted_table([60, 15, 32, *(19 / age for age in range(3, MAX_AGE + 1))])
_COMPANION = weighted_table([1, 40])


@dataclass(frozen=True)
class PayloadHeader:
    """What the first symbols say.

    count : frames in the payload
    stride : ticks of the frame clock from each frame to the next
    age : ticks from the reference to the first frame, 0 for none
    companion : the frame one stride before the reference is used too
    """

    profile: str
    count: int
    stride: int
    age: int
    second_reference: bool

    def is_staggered(self, number: int) -> bool:
        """Tell whether the payload whose first frame is `number` is staggered if it is predicted from nothing."""
        return number // (self.count * self.stride) % 2 == 1


def code_header(coder: SymbolCoder, wanted: PayloadHeader) -> PayloadHeader:
    """Code the head of a payload."""
    profile = _NAMES[coder.symbol(_PROFILE, _NAMES.index(wanted.profile))]
    count = 1 + coder.symbol(_COUNT[profile], wanted.count - 1)
    stride = 1 + coder.symbol(_STRIDE, wanted.stride - 1)
    age = coder.symbol(_AGE, wanted.age)
    companion = bool(age and coder.symbol(_COMPANION, int(wanted.second_reference)))
    return PayloadHeader(profile, count, stride, age, companion)


def profile_of(payload: bytes) -> Profile:
    """Return the profile of a payload, which says how fast its frame clock ticks. Raises ProtocolError."""
    return PROFILES[_NAMES[SymbolReader(payload).symbol(_PROFILE, 0)]]
