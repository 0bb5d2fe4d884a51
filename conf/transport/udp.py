"""The UDP sockets of both sides: one for each address family that a name has.

Strategy. A name such as `localhost` has several addresses. A listening socket is bound to all of them, a calling one
sends to all of them until one answers; from then on only that one counts. Above, there is one peer with one address.
"""

import contextlib
import errno
import ipaddress
import select
import socket
import struct
import sys
import time
from collections.abc import Sequence
from typing import Any, Self

from conf.errors import NetworkError
from conf.protocol.address import Address, RelayAddress, SocketAddress, format_address
from conf.transport.interface import ReceivedDatagram

MAX_DATAGRAM = 2048
DIRECT = "direct"  # name of the path without a relay
# What the kernel may queue while a frame is drawn, the datagrams of a flood included.
BUFFER_BYTES = 4 << 20
# Linux notes the arrival of each datagram in nanoseconds of its wall clock. Python has no name for the option.
SO_TIMESTAMPNS = 35
_TIMESPEC = struct.Struct("@ll")  # seconds, nanoseconds
_CONTROL_BYTES = 64  # of a control message that holds a timespec
MAX_QUEUED_S = 1.0  # a longer time means that the wall clock was set: it counts as 0
MAX_CANDIDATES = 8  # addresses of one name that are tried


class UdpSocket:
    """UDP sockets that act as one. Only `wait` blocks.

    remote : the address that stands for the one peer it was opened to, None for a socket that listens
    """

    def __init__(self, handles: Sequence[socket.socket], candidates: Sequence[Address] = ()) -> None:
        """Use `bind` or `open_to` instead. candidates : addresses of the peer; none for a socket that listens"""
        self._sockets = {handle.family: handle for handle in handles}
        self._candidates = list(candidates)
        self.remote = self._candidates[0] if self._candidates else None
        for handle in handles:
            handle.setblocking(False)

    @classmethod
    def bind(cls, host: str, port: int) -> Self:
        """Return a socket that listens on every address that a name has on this machine.

        host : "" for every address of this machine; port : 0 for any free one, the same for all addresses
        Raises NetworkError if no address can be bound.
        """
        handles: list[socket.socket] = []
        first_error: Exception | None = None
        try:
            found = socket.getaddrinfo(host or None, port, type=socket.SOCK_DGRAM, flags=socket.AI_PASSIVE)
        except (OSError, UnicodeError) as error:
            found, first_error = [], error
        if any(_is_many(str(address[0])) for *_, address in found):
            raise NetworkError(
                f"{host} stands for many machines: give a port alone to listen on all addresses of this one"
            )
        for family, kind, protocol, _, address in found:
            if family in {handle.family for handle in handles}:
                continue
            taken = handles[0].getsockname()[1] if handles else address[1]
            try:
                handles.append(_bound(family, kind, protocol, (address[0], taken, *address[2:])))
            except OSError as error:
                first_error = first_error or error
        if not handles:
            reason = getattr(first_error, "strerror", None) or first_error
            text = f"cannot listen on {format_address((host, port))} ({reason}): choose another with --listen HOST:PORT"
            raise NetworkError(text) from first_error
        return cls(handles)

    @classmethod
    def open_to(cls, host: str, port: int) -> Self:
        """Return a socket for datagrams to and from one peer, which may have several addresses.

        Raises NetworkError if its name has no address or stands for many machines.
        """
        try:
            found = socket.getaddrinfo(host, port, type=socket.SOCK_DGRAM)
        except (OSError, UnicodeError) as error:
            raise NetworkError(f"no address for {host!r}: give the receiver's name or number as HOST:PORT") from error
        candidates: list[Any] = list(dict.fromkeys(address for *_, address in found))[:MAX_CANDIDATES]
        if any(_is_many(address[0]) for address in candidates):
            raise NetworkError(f"{host} stands for many machines: give the address of one, as HOST:PORT")
        handles: dict[socket.AddressFamily, socket.socket] = {}
        failure: OSError | None = None
        for family in {_family(address) for address in candidates}:
            try:
                handles[family] = socket.socket(family, socket.SOCK_DGRAM)
                _stamp_arrivals(handles[family])
            except OSError as error:  # a name may have IPv6 addresses on a machine without IPv6
                failure = error
        if not handles:
            raise NetworkError(_send_failure(failure or OSError("no address"), candidates[0])) from failure
        return cls(list(handles.values()), [address for address in candidates if _family(address) in handles])

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Close all sockets."""
        for handle in self._sockets.values():
            handle.close()

    @property
    def handles(self) -> list[socket.socket]:
        """What becomes readable when a datagram has arrived."""
        return list(self._sockets.values())

    @property
    def address(self) -> tuple[str, int]:
        """The first local host and port."""
        host, port = next(iter(self._sockets.values())).getsockname()[:2]
        return host, port

    @property
    def candidates(self) -> tuple[Address, ...]:
        """No addresses: the peer has found this end."""
        return ()

    @property
    def nameplate(self) -> str:
        """No number: there is no relay."""
        return ""

    @property
    def others_wait(self) -> bool:
        """Whether another end waits: not known."""
        return True

    def path_name(self, address: Address, /) -> str:
        """Return how datagrams reach an address."""
        return DIRECT

    def receive(self, limit: int = 4096) -> list[ReceivedDatagram]:
        """Return the datagrams that have arrived, at most `limit` for each address family.

        Raises NetworkError if there are none because this machine cannot receive.
        """
        datagrams: list[ReceivedDatagram] = []
        failure: OSError | None = None
        now = _timestamp_clock()
        for handle in self._sockets.values():
            for _ in range(limit):
                try:
                    datagrams.append(self._known(_receive_one(handle, now)))
                except ConnectionError:  # of a datagram sent earlier: nobody listens on the peer's port
                    continue
                except BlockingIOError:  # nothing more
                    break
                except OSError as error:
                    if error.errno == errno.EMSGSIZE:  # Windows: junk longer than MAX_DATAGRAM
                        continue
                    failure = error
                    break
        if failure is not None and not datagrams:
            reason = failure.strerror or failure
            raise NetworkError(f"nothing can be received ({reason}): check this machine's network") from failure
        return datagrams

    def send(self, datagrams: list[tuple[bytes, Address]]) -> None:
        """Send datagrams. One that the network cannot carry is lost.

        Raises NetworkError, after all were tried, if this machine could send none of them; a socket that was opened
        to a peer counts only those to it.
        """
        failure: tuple[OSError, Address] | None = None
        tried = sent = 0
        for data, address in datagrams:
            targets = self._candidates if address == self.remote else [address]
            for target in targets:
                tried += self.remote in (None, address)
                try:
                    self._socket_for(target).sendto(data, target)
                    sent += 1
                except (BlockingIOError, ConnectionError):
                    sent += 1  # lost on its way, as any other may be
                except OSError as error:
                    failure = failure or (error, target)
        if failure is not None and tried and not sent:
            raise NetworkError(_send_failure(*failure)) from failure[0]

    def wait(self, seconds: float) -> None:
        """Sleep until a datagram arrives, at most `seconds`."""
        select.select(self.handles, [], [], max(seconds, 0.0))

    def renew(self) -> None:
        """Do nothing: there is no relay."""

    def _known(self, datagram: ReceivedDatagram) -> ReceivedDatagram:
        """Return a datagram of the peer as from `remote`. The first candidate that answers is used afterwards."""
        if datagram.address in self._candidates:
            self._candidates = [datagram.address]
            return datagram._replace(address=self.remote or datagram.address)
        return datagram

    def _socket_for(self, address: Address) -> socket.socket:
        handle = None if isinstance(address, RelayAddress) else self._sockets.get(_family(address))
        if handle is None:
            raise OSError(f"no socket for {format_address(address)}")
        return handle


def resolve(host: str, port: int, /) -> list[SocketAddress]:
    """Return the addresses of a name, as sockets report them. Raises NetworkError."""
    try:
        found = socket.getaddrinfo(host, port, type=socket.SOCK_DGRAM)
    except (OSError, UnicodeError, OverflowError) as error:
        raise NetworkError(f"no address for {host!r}: check the name and this machine's network") from error
    addresses: list[Any] = list(dict.fromkeys(address for *_, address in found))[:MAX_CANDIDATES]
    return addresses


if sys.platform == "linux":

    def _timestamp_clock() -> float:
        return time.clock_gettime(time.CLOCK_REALTIME)

    def _stamp_arrivals(handle: socket.socket) -> None:
        handle.setsockopt(socket.SOL_SOCKET, SO_TIMESTAMPNS, 1)

    def _receive_one(handle: socket.socket, now: float) -> ReceivedDatagram:
        data, control, _, address = handle.recvmsg(MAX_DATAGRAM, _CONTROL_BYTES)
        for level, kind, value in control:
            if (level, kind) == (socket.SOL_SOCKET, SO_TIMESTAMPNS) and len(value) == _TIMESPEC.size:
                seconds, nanoseconds = _TIMESPEC.unpack(value)
                queued_s = now - seconds - nanoseconds * 1e-9
                return ReceivedDatagram(data, address, queued_s if 0 < queued_s < MAX_QUEUED_S else 0.0)
        return ReceivedDatagram(data, address, 0.0)

else:

    def _timestamp_clock() -> float:
        return 0.0

    def _stamp_arrivals(handle: socket.socket) -> None:
        """Do nothing: only Linux tells the time of arrival."""

    def _receive_one(handle: socket.socket, now: float) -> ReceivedDatagram:
        return ReceivedDatagram(*handle.recvfrom(MAX_DATAGRAM), 0.0)


def _bound(family: int, kind: int, protocol: int, address: Any) -> socket.socket:
    """Return a bound socket with its options set. Raises OSError if it cannot be bound."""
    handle = socket.socket(family, kind, protocol)
    try:
        if family == socket.AF_INET6:
            handle.setsockopt(socket.IPPROTO_IPV6, socket.IPV6_V6ONLY, 1)  # IPv4 has a socket of its own
        with contextlib.suppress(OSError):  # Linux gives what it allows, others refuse more than they allow
            handle.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, BUFFER_BYTES)
        _stamp_arrivals(handle)
        handle.bind(address)
    except OSError:
        handle.close()
        raise
    return handle


def _family(address: Address) -> socket.AddressFamily:
    return socket.AF_INET6 if len(address) == 4 else socket.AF_INET


def _is_many(host: str) -> bool:
    """Return whether an address is a multicast or the broadcast address."""
    address = ipaddress.ip_address(host.split("%")[0])
    mapped = getattr(address, "ipv4_mapped", None)
    return address.is_multicast or (mapped is not None and mapped.is_multicast) or host == "255.255.255.255"


def _send_failure(error: OSError, address: Address) -> str:
    if error.errno == errno.EACCES:  # of a firewall it is EPERM on Linux
        return f"{format_address(address)} stands for many machines, or a firewall forbids it: give the address of one"
    if isinstance(error, PermissionError):
        return f"this machine may not send to {format_address(address)}: check its firewall"
    return f"nothing can be sent to {format_address(address)} ({error.strerror or error}): check this machine's network"
