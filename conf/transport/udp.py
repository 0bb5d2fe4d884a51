"""The receiver's socket."""

import contextlib
import select
import socket
import struct
import sys
import time
from types import TracebackType
from typing import Any, NamedTuple

from conf.errors import NetworkError
from conf.protocol.session.flood_protection import Address

MAX_DATAGRAM = 2048
BUFFER_BYTES = 4 << 20  # what the system may hold for us while a frame is drawn, junk of a flood included


# Linux notes when a datagram comes in, to the nanosecond of its wall clock; Python has no name for the option.
SO_TIMESTAMPNS = 35
_STAMP = struct.Struct("@ll")  # seconds, nanoseconds
_STAMP_ROOM = 64  # bytes of a control message that holds one
MAX_QUEUED_S = 1.0  # a wall clock that was set says more: it is not believed


class ReceivedDatagram(NamedTuple):
    """A datagram, where it came from, and the seconds it has lain in the system's buffer (0 where that is not told)."""

    data: bytes
    address: Address
    queued_s: float


class UdpSocket:
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

    def __enter__(self) -> "UdpSocket":
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

    def receive(self, limit: int = 4096) -> list[ReceivedDatagram]:
        """Take what has come, `limit` datagrams at most."""
        arrivals: list[ReceivedDatagram] = []
        now = time.clock_gettime(time.CLOCK_REALTIME)  # the stamps are of this clock
        with contextlib.suppress(OSError):  # nothing more, or the word that an answer of ours found nobody
            while len(arrivals) < limit:
                arrivals.append(self._take(now))
        return arrivals

    if sys.platform == "linux":

        def _take(self, now: float) -> ReceivedDatagram:
            data, control, _, address = self._socket.recvmsg(MAX_DATAGRAM, _STAMP_ROOM)
            for level, kind, stamp in control:
                if (level, kind) == (socket.SOL_SOCKET, SO_TIMESTAMPNS) and len(stamp) == _STAMP.size:
                    seconds, nanoseconds = _STAMP.unpack(stamp)
                    waited = now - seconds - nanoseconds * 1e-9
                    return ReceivedDatagram(data, address, waited if 0 < waited < MAX_QUEUED_S else 0.0)
            return ReceivedDatagram(data, address, 0.0)

    else:

        def _take(self, now: float) -> ReceivedDatagram:
            return ReceivedDatagram(*self._socket.recvfrom(MAX_DATAGRAM), 0.0)

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
        if sys.platform == "linux":
            link.setsockopt(socket.SOL_SOCKET, SO_TIMESTAMPNS, 1)
        link.bind(address)
    except OSError:
        link.close()
        raise
    return link
