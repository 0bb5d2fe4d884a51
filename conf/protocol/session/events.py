"""The events of a session."""

from dataclasses import dataclass
from enum import StrEnum

from conf.protocol.address import Address
from conf.protocol.session.handshake import Refusal


class LossReason(StrEnum):
    """Why a session ended."""

    IDLE = "idle"  # nothing received for 30 s
    REPLACED = "replaced"  # by a new handshake of the same sender
    EXHAUSTED = "exhausted"  # 2^32 datagrams sent
    CLOSED = "closed"  # closed on this side
    HUNG_UP = "hung_up"  # by the peer


@dataclass(frozen=True)
class Connected:
    """A session is ready. After a reconnection it is a new one: its counters start at 0, nothing is acknowledged."""

    session: int
    address: Address


@dataclass(frozen=True)
class WrongCode:
    """The code is wrong. At the sender: it has stopped trying. At the receiver: a sender at `address` used it."""

    tries_left: int
    address: Address


@dataclass(frozen=True)
class Refused:
    """The receiver refuses this sender. wait_s : seconds until the sender tries again, None if never"""

    refusal: Refusal
    wait_s: float | None


@dataclass(frozen=True)
class NoAnswer:
    """At the sender: no answer to the handshake for `seconds`; it continues to try."""

    seconds: float


@dataclass(frozen=True)
class BodyReceived:
    """An authenticated body. counter : of its datagram, unique in the session, rising in the order of sending"""

    session: int
    body: bytes
    address: Address
    counter: int


@dataclass(frozen=True)
class AddressChanged:
    """The session's peer has a new address."""

    session: int
    address: Address


@dataclass(frozen=True)
class SessionEnded:
    """A session has ended. Its number may be used again."""

    session: int
    reason: LossReason


Event = Connected | WrongCode | Refused | NoAnswer | BodyReceived | AddressChanged | SessionEnded
