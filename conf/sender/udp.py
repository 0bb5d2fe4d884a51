"""The sender's socket."""

import contextlib
import select
import socket
from types import TracebackType
from typing import Any

from conf.errors import NetworkError

MAX_DATAGRAM = 2048


class SenderSocket:
    """A UDP socket towards one receiver. Never blocks but in `wait`."""

    def __init__(self, host: str, port: int) -> None:
        """Resolve the receiver's name. Raises NetworkError when it has no address."""
        try:
            found = socket.getaddrinfo(host, port, type=socket.SOCK_DGRAM)
        except (OSError, UnicodeError) as error:
            raise NetworkError(f"no address for {host!r}: give the receiver's name or number as HOST:PORT") from error
        family, kind, protocol, _, address = found[0]
        self._socket = socket.socket(family, kind, protocol)
        self._socket.setblocking(False)
        self._peer: tuple[Any, ...] = address
        self.unsent = 0

    def __enter__(self) -> "SenderSocket":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._socket.close()

    def send(self, datagrams: list[bytes]) -> None:
        """Send, or lose: a full queue or an absent receiver is the network's business, the protocol copes with loss."""
        for data in datagrams:
            try:
                self._socket.sendto(data, self._peer)
            except PermissionError as error:
                raise NetworkError(f"this machine may not send to {self._peer[0]}: check its firewall") from error
            except OSError:
                self.unsent += 1

    def receive(self) -> list[bytes]:
        """Take all that has come."""
        datagrams: list[bytes] = []
        with contextlib.suppress(OSError):  # nothing more, or the word that nobody listens over there
            while len(datagrams) < 64:
                data, sender = self._socket.recvfrom(MAX_DATAGRAM)
                if sender[:2] == self._peer[:2]:
                    datagrams.append(data)
        return datagrams

    def wait(self, seconds: float) -> None:
        """Sleep until something comes, `seconds` at most."""
        select.select([self._socket], [], [], max(seconds, 0.0))
