"""The UDP socket of both sides."""

import select
import socket
import struct
import sys
import time
from types import TracebackType
from typing import Any, NamedTuple, Self, cast

from conf.errors import NetworkError
from conf.protocol.address import Address

MAX_DATAGRAM = 2048
# What the kernel may queue while a frame is drawn, the datagrams of a flood included.
BUFFER_BYTES = 4 << 20
# Linux notes the arrival of each datagram in nanoseconds of its wall clock. Python has no name for the option.
SO_TIMESTAMPNS = 35
_TIMESPEC = struct.Struct("@ll")  # seconds, nanoseconds
_CONTROL_BYTES = 64  # of a control message that holds a timespec
MAX_QUEUED_S = 1.0  # a longer time means that the wall clock was set: it counts as 0


class ReceivedDatagram(NamedTuple):
    """A datagram, its source, and the seconds it spent in the kernel's queue (0 where the system does not tell)."""

    data: bytes
    address: Address
    queued_s: float


class UdpSocket:
    """A UDP socket. Only `wait` blocks.

    remote : the address of the one peer it was opened to, None for a socket that listens
    """

    def __init__(self, handle: socket.socket, remote: Address | None = None) -> None:
        """Use `bind` or `open_to` instead."""
        self.remote = remote
        self._socket = handle
        handle.setblocking(False)

    @classmethod
    def bind(cls, host: str, port: int) -> Self:
        """Return a socket that listens on an address of this machine; port 0 for any free one.

        Raises NetworkError if the address is in use or not of this machine.
        """
        try:
            family, kind, protocol, _, address = socket.getaddrinfo(
                host, port, type=socket.SOCK_DGRAM, flags=socket.AI_PASSIVE
            )[0]
            return cls(_bound(socket.socket(family, kind, protocol), address))
        except (OSError, UnicodeError) as error:
            raise NetworkError(
                f"cannot listen on {host}:{port} ({getattr(error, 'strerror', None) or error}): "
                "choose another with --listen HOST:PORT"
            ) from error

    @classmethod
    def open_to(cls, host: str, port: int) -> Self:
        """Return a socket for datagrams to and from one peer. Raises NetworkError if its name has no address."""
        try:
            family, kind, protocol, _, address = socket.getaddrinfo(host, port, type=socket.SOCK_DGRAM)[0]
        except (OSError, UnicodeError) as error:
            raise NetworkError(f"no address for {host!r}: give the receiver's name or number as HOST:PORT") from error
        return cls(socket.socket(family, kind, protocol), cast(Address, address))

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._socket.close()

    @property
    def address(self) -> tuple[str, int]:
        """The local host and port."""
        host, port = self._socket.getsockname()[:2]
        return host, port

    def receive(self, limit: int = 4096) -> list[ReceivedDatagram]:
        """Return the datagrams that have arrived, at most `limit`."""
        datagrams: list[ReceivedDatagram] = []
        # The clock of the timestamps.
        now = time.clock_gettime(time.CLOCK_REALTIME) if sys.platform == "linux" else 0.0
        for _ in range(limit):
            try:
                datagrams.append(self._receive_one(now))
            except ConnectionError:  # of a datagram sent earlier: nobody listens on the peer's port
                continue
            except OSError:  # nothing more
                break
        return datagrams

    if sys.platform == "linux":

        def _receive_one(self, now: float) -> ReceivedDatagram:
            data, control, _, address = self._socket.recvmsg(MAX_DATAGRAM, _CONTROL_BYTES)
            for level, kind, value in control:
                if (level, kind) == (socket.SOL_SOCKET, SO_TIMESTAMPNS) and len(value) == _TIMESPEC.size:
                    seconds, nanoseconds = _TIMESPEC.unpack(value)
                    queued_s = now - seconds - nanoseconds * 1e-9
                    return ReceivedDatagram(data, address, queued_s if 0 < queued_s < MAX_QUEUED_S else 0.0)
            return ReceivedDatagram(data, address, 0.0)

    else:

        def _receive_one(self, now: float) -> ReceivedDatagram:
            return ReceivedDatagram(*self._socket.recvfrom(MAX_DATAGRAM), 0.0)

    def send(self, datagrams: list[tuple[bytes, Address]]) -> None:
        """Send datagrams. One that cannot be sent is lost, as on the network.

        Raises NetworkError if this machine forbids datagrams to `remote`.
        """
        for data, address in datagrams:
            try:
                self._socket.sendto(data, address)
            except PermissionError as error:
                if address == self.remote:
                    raise NetworkError(f"this machine may not send to {address[0]}: check its firewall") from error
            except OSError:
                continue

    def wait(self, seconds: float) -> None:
        """Sleep until a datagram arrives, at most `seconds`."""
        select.select([self._socket], [], [], max(seconds, 0.0))


def _bound(handle: socket.socket, address: Any) -> socket.socket:
    """Return the socket bound and with its options set. Closes it and raises OSError if it cannot be bound."""
    try:
        handle.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, BUFFER_BYTES)
        if sys.platform == "linux":
            handle.setsockopt(socket.SOL_SOCKET, SO_TIMESTAMPNS, 1)
        handle.bind(address)
    except OSError:
        handle.close()
        raise
    return handle
