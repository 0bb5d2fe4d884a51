"""The interface of everything that carries datagrams: UDP, a relay, or both at once."""

from collections.abc import Sequence
from types import TracebackType
from typing import NamedTuple, Protocol, Self

from conf.protocol.address import Address


class ReceivedDatagram(NamedTuple):
    """A datagram, its source, and the seconds it waited to be received (0 where the system does not tell)."""

    data: bytes
    address: Address
    queued_s: float


class HasFileno(Protocol):
    """What `select` can wait for."""

    def fileno(self) -> int: ...


class Transport(Protocol):
    """Sends and receives datagrams. Only `wait` blocks."""

    @property
    def remote(self) -> Address | None:
        """The address that stands for the one peer it was opened to, None if it waits for any."""

    @property
    def address(self) -> Address:
        """The address of this end."""

    @property
    def candidates(self) -> tuple[Address, ...]:
        """The addresses at which this end may be reached directly; none if its peer has a path already."""

    @property
    def nameplate(self) -> str:
        """The number under which the ends find each other on a relay, "" without a relay."""

    @property
    def others_wait(self) -> bool:
        """Whether another end waits with the nameplate, as far as known."""

    def path_name(self, address: Address, /) -> str:
        """Return in words how datagrams reach an address: "direct", "relay" or "relay over TCP"."""

    def receive(self, limit: int, /) -> list[ReceivedDatagram]:
        """Return the datagrams that have arrived, at most about `limit`.

        Raises NetworkError if there are none because this machine cannot receive.
        """

    def send(self, datagrams: list[tuple[bytes, Address]], /) -> None:
        """Send datagrams. One that the network cannot carry is lost.

        Raises NetworkError, after all were tried, if none could be sent.
        """

    def wait(self, seconds: float, /) -> None:
        """Sleep until a datagram arrives, at most `seconds`."""

    def renew(self) -> None:
        """Reach the relay in another way, if there is one and that was not tried just now."""

    def close(self) -> None:
        """Free what it uses."""

    def __enter__(self) -> Self: ...

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None, /
    ) -> None: ...


class SelectableTransport(Transport, Protocol):
    """A transport that can be waited for together with others."""

    @property
    def handles(self) -> Sequence[HasFileno]:
        """What becomes readable when a datagram has arrived."""
