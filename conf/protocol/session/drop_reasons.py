"""The reasons for which datagrams are dropped: counted, never formatted, as junk may arrive 50,000 times a second."""

from enum import StrEnum

from conf.errors import ProtocolError


class DropReason(StrEnum):
    """The keys of the `dropped` counts on both sides."""

    SIZE = "size"  # shorter or longer than any datagram
    VERSION = "version"  # another version of the protocol
    SYNTAX = "syntax"  # not the canonical msgpack of WIRE.md
    CHECKSUM = "checksum"  # a handshake datagram damaged on the network
    UNKNOWN_SESSION = "unknown_session"  # sealed for a session that does not exist here
    UNKNOWN_ATTEMPT = "unknown_attempt"  # a handshake datagram of no handshake of ours
    SEAL = "seal"  # the authentication tag is wrong
    REPLAYED = "replayed"  # received before
    TOO_OLD = "too_old"  # behind the replay window
    COUNTER = "counter"  # too far ahead for the keys at hand
    SHARE = "share"  # not a point of the curve
    RATE = "rate"  # more hellos a second than are answered
    DIRECTION = "direction"  # a kind that this side never receives
    GLARE = "glare"  # a call that has crossed ours, which goes on


class DatagramError(ProtocolError):
    """A datagram was dropped for `reason`; nothing else has changed."""

    def __init__(self, reason: DropReason) -> None:
        super().__init__(reason)
        self.reason = reason
