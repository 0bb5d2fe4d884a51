"""The receiver's socket."""

import contextlib
import select
import socket
from types import TracebackType
from typing import Any

from conf.errors import NetworkError
from conf.protocol.session.limits import Address

MAX_DATAGRAM = 2048
BUFFER_BYTES = 4 << 20  # what the system may hold for us while a frame is drawn, junk of a flood included


class ReceiverSocket:
    """A UDP socket that listens. Never blocks but in `wait`."""

    def __init__(self, host: str, port: int) -> None:
        """Bind to an address of this machine. Raises NetworkError when it is taken or not ours."""
        try:
            family, kind, protocol, _, address = socket.getaddrinfo(
                host, port, type=socket.SOCK_DGRAM, flags=socket.AI_PASSIVE
            )[0]
            self._socket = _bound(socket.socket(family, kind, protocol), address)
        except (OSError, UnicodeError) as error:
            raise NetworkError(
                f"cannot listen on {host}:{port} ({getattr(error, 'strerror', None) or error}): "
                "choose another with --listen HOST:PORT"
            ) from error
        self._socket.setblocking(False)

    def __enter__(self) -> "ReceiverSocket":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._socket.close()

    @property
    def address(self) -> tuple[str, int]:
        """Where it listens: host and port."""
        host, port = self._socket.getsockname()[:2]
        return host, port

    def receive(self, limit: int = 4096) -> list[tuple[bytes, Address]]:
        """Take what has come, `limit` datagrams at most."""
        datagrams: list[tuple[bytes, Address]] = []
        with contextlib.suppress(OSError):  # nothing more, or the word that an answer of ours found nobody
            while len(datagrams) < limit:
                datagrams.append(self._socket.recvfrom(MAX_DATAGRAM))
        return datagrams

    def send(self, datagrams: list[tuple[bytes, Address]]) -> None:
        """Send answers. What cannot be sent is lost: the protocol copes with loss."""
        for data, address in datagrams:
            with contextlib.suppress(OSError):
                self._socket.sendto(data, address)

    def wait(self, seconds: float) -> None:
        """Sleep until something comes, `seconds` at most."""
        select.select([self._socket], [], [], max(seconds, 0.0))


def _bound(link: socket.socket, address: Any) -> socket.socket:
    """Bind a socket, or close it."""
    try:
        link.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, BUFFER_BYTES)
        link.bind(address)
    except OSError:
        link.close()
        raise
    return link
