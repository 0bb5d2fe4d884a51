"""The ports of a relay: what stands between strangers and zenoh's router, which limits and counts nothing itself.

Strategy. The router listens on this machine only. One loop carries all datagrams and connections to it and back, with a
limit for each member, and answers STUN requests. That costs about 14 us a datagram, a third of what the router needs.
"""

import selectors
import socket
import sys
import time
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from types import TracebackType
from typing import Self

from conf.errors import NetworkError
from conf.protocol.address import format_address
from conf.relay.router import ROUTER_HOST
from conf.relay.stun_responder import StunResponder
from conf.relay.tcp_front import BACKLOG, TcpFront
from conf.relay.udp_front import UdpFront
from conf.transport.udp import UdpSocket, resolve

FLOWS_PER_MEMBER = 2  # of each protocol: who comes back may have left an old one
MAX_FLOWS = sys.maxsize if sys.platform != "win32" else 150  # Windows waits for 512 sockets at most
EXPIRE_S = 1.0
RESUME_S = 0.02  # how exactly limits of TCP are kept
UDP_FILES, TCP_FILES = 2, 3  # of a flow: the router's end of the connection to it is in this process too
FILES_PER_MEMBER = FLOWS_PER_MEMBER * (UDP_FILES + TCP_FILES)
OTHER_FILES = 480  # flows that are pending, and what a program has open


@dataclass(frozen=True)
class FrontCounts:
    """Counts so far.

    forwarded : UDP datagrams to the router
    strangers : datagrams of no member, and TCP connections that sent something else before a session was accepted
    excess : above the limit of a member; overflows : dropped by the system as they came too fast, 0 where it does not
    tell; refused : flows and connections that were not admitted, or opened no session in time
    tcp_bytes : both ways; tcp_pauses : waits of TCP above its limit
    """

    forwarded: int = 0
    strangers: int = 0
    excess: int = 0
    overflows: int = 0
    refused: int = 0
    tcp_bytes: int = 0
    tcp_pauses: int = 0
    stun_answered: int = 0
    stun_ignored: int = 0

    @property
    def dropped(self) -> int:
        """Return how many datagrams were dropped."""
        return self.strangers + self.excess + self.overflows + self.stun_ignored


class Front:
    """The ports of a relay; use `with`.

    router_ports : where the router must listen over TCP, for what comes over TCP and over UDP
    """

    def __init__(self, udp: UdpSocket, tcp: Sequence[socket.socket], stun: StunResponder, options: "FrontOptions"):
        """Use `bind` instead."""
        self.router_ports = find_router_ports()
        hosts = {str(address[0]) for peer in options.peers for address in resolve(*peer)}
        max_flows = min(FLOWS_PER_MEMBER * (options.max_members + len(hosts)), MAX_FLOWS)
        self._selector = selectors.DefaultSelector()
        reliable, best_effort = ((ROUTER_HOST, port) for port in self.router_ports)
        self._tcp = TcpFront(tcp, reliable, self._selector, max_flows=max_flows, peers=hosts)
        self._udp = UdpFront(udp, best_effort, self._selector, max_flows=max_flows, peers=hosts)
        self._stun = stun
        self._expire_at = float("-inf")
        for handle in stun.handles:
            self._selector.register(handle, selectors.EVENT_READ, lambda _, now: stun.step(now))

    @classmethod
    def bind(cls, options: "FrontOptions") -> Self:
        """Return the ports of a relay. Raises NetworkError if one of them is in use."""
        host, port = options.listen
        allow_files(FILES_PER_MEMBER * options.max_members + OTHER_FILES)
        with ExitStack() as stack:
            stun = stack.enter_context(StunResponder.bind(host, port))
            udp = stack.enter_context(UdpSocket.bind(host, port))
            tcp = [stack.enter_context(_listener(handle)) for handle in udp.handles]
            front = cls(udp, tcp, stun, options)
            stack.pop_all()
        return front

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._udp.close()
        self._tcp.close()
        self._stun.close()
        self._selector.close()

    @property
    def stun_ports(self) -> list[int]:
        """Return the ports that answer STUN requests."""
        return self._stun.ports

    def step(self, seconds: float, clock: Callable[[], float] = time.monotonic) -> None:
        """Wait for something to arrive, at most `seconds`, and carry it."""
        is_waiting = self._tcp.is_waiting
        ready = self._selector.select(max(0.0, min(seconds, RESUME_S) if is_waiting else seconds))
        now = clock()
        for key, mask in ready:
            key.data(mask, now)
        if is_waiting:
            self._tcp.resume(now)
        if now >= self._expire_at:
            self._expire_at = now + EXPIRE_S
            self._udp.expire(now)
            self._tcp.expire(now)

    def counts(self) -> FrontCounts:
        """Return the counts so far."""
        return FrontCounts(
            forwarded=self._udp.forwarded,
            strangers=self._udp.strangers + self._tcp.strangers,
            excess=self._udp.excess,
            overflows=self._udp.overflows,
            refused=self._udp.refused + self._tcp.refused,
            tcp_bytes=self._tcp.read_bytes,
            tcp_pauses=self._tcp.paused,
            stun_answered=self._stun.answered,
            stun_ignored=self._stun.ignored,
        )


@dataclass(frozen=True)
class FrontOptions:
    """listen : host and port, host "" for all addresses; peers : other relays, which may carry more than members"""

    listen: tuple[str, int]
    max_members: int
    peers: Sequence[tuple[str, int]] = ()


def find_router_ports() -> tuple[int, int]:
    """Return two TCP ports of this machine that nobody uses."""
    with socket.create_server((ROUTER_HOST, 0)) as first, socket.create_server((ROUTER_HOST, 0)) as second:
        return int(first.getsockname()[1]), int(second.getsockname()[1])


def allow_files(count: int, /) -> None:
    """Let this process open as many files as the system allows it, at most `count`."""
    if sys.platform == "win32":
        return
    import resource

    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    wanted = count if hard == resource.RLIM_INFINITY else min(count, hard)
    if soft != resource.RLIM_INFINITY and wanted > soft:
        resource.setrlimit(resource.RLIMIT_NOFILE, (wanted, hard))


def _listener(udp: socket.socket) -> socket.socket:
    """Return a TCP socket that listens at the address of a UDP socket. Raises NetworkError."""
    address = udp.getsockname()
    try:
        return socket.create_server(address[:2], family=udp.family, backlog=BACKLOG)
    except OSError as error:
        reason = error.strerror or error
        text = f"cannot listen on {format_address(address[:2])} over TCP ({reason}): choose another with --listen"
        raise NetworkError(f"{text} HOST:PORT") from error
