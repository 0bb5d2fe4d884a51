"""Why a datagram was dropped. A reason is counted, never formatted: junk comes 50,000 times a second."""

from enum import StrEnum

from conf.errors import ProtocolError


class DropReason(StrEnum):
    """The keys of the `dropped` counts on both sides."""

    SIZE = "size"  # shorter or longer than any datagram
    VERSION = "version"  # another version of the protocol
    SYNTAX = "syntax"  # not the canonical msgpack of WIRE.md
    CHECKSUM = "checksum"  # a handshake datagram damaged on the way
    UNKNOWN_SESSION = "unknown_session"  # sealed for a session that is not here
    UNKNOWN_ATTEMPT = "unknown_attempt"  # a handshake datagram that belongs to no handshake of ours
    SEAL = "seal"  # the tag does not fit
    REPLAYED = "replayed"  # seen before
    TOO_OLD = "too_old"  # behind the replay window
    COUNTER = "counter"  # a counter too far ahead for the keys at hand
    SHARE = "share"  # not a point of the curve
    RATE = "rate"  # more hellos a second than are answered
    DIRECTION = "direction"  # a kind that this side never receives


class DatagramError(ProtocolError):
    """A datagram was dropped for `reason`; nothing else has changed."""

    def __init__(self, reason: DropReason) -> None:
        super().__init__(reason)
        self.reason = reason
