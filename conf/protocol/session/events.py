"""What a session tells the program above it."""

from dataclasses import dataclass
from enum import StrEnum

from conf.protocol.address import Address
from conf.protocol.session.handshake import Refusal


class LossReason(StrEnum):
    """Why a session ended."""

    IDLE = "idle"  # nothing heard for 30 s
    REPLACED = "replaced"  # the same sender has shaken hands again
    EXHAUSTED = "exhausted"  # 2^32 datagrams sent
    CLOSED = "closed"  # closed by this side's program


@dataclass(frozen=True)
class Connected:
    """A session is ready; after a reconnection it is a new one: its counters start at 0, nothing is acknowledged."""

    session: int
    address: Address


@dataclass(frozen=True)
class WrongCode:
    """The code is wrong. At the sender: it has stopped trying. At the receiver: somebody at `address` tried."""

    tries_left: int
    address: Address


@dataclass(frozen=True)
class Refused:
    """The receiver will not talk to this sender now; wait_s : seconds until the sender tries again, None if never."""

    refusal: Refusal
    wait_s: float | None


@dataclass(frozen=True)
class NoAnswer:
    """At the sender: nobody has answered the handshake for `seconds`; it goes on trying."""

    seconds: float


@dataclass(frozen=True)
class BodyReceived:
    """A body under a valid seal. counter : its datagram's, unique in the session, rising in the order of sending."""

    session: int
    body: bytes
    address: Address
    counter: int


@dataclass(frozen=True)
class AddressChanged:
    """At the receiver: the session's sender has a new address."""

    session: int
    address: Address


@dataclass(frozen=True)
class SessionEnded:
    """A session has ended; its number may be used again."""

    session: int
    reason: LossReason


@dataclass(frozen=True)
class SealedDatagram:
    """A body on its way: the datagram, where to, and its counter, by which it will be acknowledged."""

    datagram: bytes
    address: Address
    counter: int


Event = Connected | WrongCode | Refused | NoAnswer | BodyReceived | AddressChanged | SessionEnded
