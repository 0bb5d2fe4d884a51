"""The payload header: profile, number of frames, their distance and their reference.

The tables are fixed. They favour the usual header, which costs less than one bit beside the age of the reference.
"""

from dataclasses import dataclass

from conf.protocol.codec.profiles import LIVE, PROFILES, Profile
from conf.protocol.codec.reference_frames import MAX_AGE
from conf.protocol.codec.symbol_coder import SymbolCoder, SymbolReader, weighted_table

MAX_FRAMES = 8
MAX_STRIDE = 4

_NAMES = tuple(PROFILES)
_PROFILE = weighted_table([30, 2, 2, 2, 2])
_COUNT = {
    name: weighted_table([300 if count in profile.usual_counts else 1 for count in range(1, MAX_FRAMES + 1)])
    for name, profile in PROFILES.items()
}
_STRIDE = weighted_table([300, 3, 1, 1])
_AGE = weighted_table([60, 15, 32, *(19 / age for age in range(3, MAX_AGE + 1))])
_SECOND_REFERENCE = weighted_table([1, 40])


@dataclass(frozen=True)
class PayloadHeader:
    """The first symbols of a payload.

    count : frames in the payload
    stride : ticks of the frame clock from each frame to the next
    age : ticks from the reference to the first frame, 0 for no reference
    second_reference : the frame one stride before the reference is used too
    """

    profile: str
    count: int
    stride: int
    age: int
    second_reference: bool

    def is_staggered(self, frame_number: int) -> bool:
        """Return whether a payload without reference is staggered, given the number of its first frame."""
        return frame_number // (self.count * self.stride) % 2 == 1


_UNREAD = PayloadHeader(LIVE.name, count=1, stride=1, age=0, second_reference=False)


def code_header(coder: SymbolCoder, header: PayloadHeader = _UNREAD) -> PayloadHeader:
    """Code the header of a payload and return it. A reader needs no `header`."""
    profile = _NAMES[coder.symbol(_PROFILE, _NAMES.index(header.profile))]
    count = 1 + coder.symbol(_COUNT[profile], header.count - 1)
    stride = 1 + coder.symbol(_STRIDE, header.stride - 1)
    age = coder.symbol(_AGE, header.age)
    second_reference = bool(age and coder.symbol(_SECOND_REFERENCE, int(header.second_reference)))
    return PayloadHeader(profile, count, stride, age, second_reference)


def profile_of(payload: bytes) -> Profile:
    """Return the profile of a payload, which gives the rate of its frame clock. Raises ProtocolError."""
    return PROFILES[_NAMES[SymbolReader(payload).symbol(_PROFILE)]]
