"""The sender's socket."""

import contextlib
import select
import socket
from types import TracebackType
from typing import cast

from conf.errors import NetworkError
from conf.protocol.session.flood_protection import Address

MAX_DATAGRAM = 2048


class UdpSocket:
    """A UDP socket towards one receiver. Never blocks but in `wait`."""

    def __init__(self, host: str, port: int) -> None:
        """Resolve the receiver's name. Raises NetworkError when it has no address."""
        try:
            found = socket.getaddrinfo(host, port, type=socket.SOCK_DGRAM)
        except (OSError, UnicodeError) as error:
            raise NetworkError(f"no address for {host!r}: give the receiver's name or number as HOST:PORT") from error
        family, kind, protocol, _, address = found[0]
        self.remote = cast(Address, address)
        self._socket = socket.socket(family, kind, protocol)
        self._socket.setblocking(False)

    def __enter__(self) -> "UdpSocket":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._socket.close()

    def send(self, datagrams: list[tuple[bytes, Address]]) -> None:
        """Send, or lose: a full queue or an unreachable network is lost like anything else on the way."""
        for data, address in datagrams:
            try:
                self._socket.sendto(data, address)
            except PermissionError as error:
                raise NetworkError(f"this machine may not send to {address[0]}: check its firewall") from error
            except OSError:
                continue

    def receive(self) -> list[tuple[bytes, Address]]:
        """Take all that has come."""
        datagrams: list[tuple[bytes, Address]] = []
        with contextlib.suppress(BlockingIOError):
            while len(datagrams) < 256:
                try:
                    data, sender = self._socket.recvfrom(MAX_DATAGRAM)
                except ConnectionError:  # the word that nobody listens over there, for a datagram sent before
                    continue
                datagrams.append((data, sender))
        return datagrams

    def wait(self, seconds: float) -> None:
        """Sleep until something comes, `seconds` at most."""
        select.select([self._socket], [], [], max(seconds, 0.0))
