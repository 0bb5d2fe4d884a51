"""One end of calls that reaches the other over a relay, and directly where the routers between them let it.

Strategy. The protocol chooses the path; here is what it needs: a UDP socket beside the relay, and the addresses at
which this socket can be reached: those of this machine and the one that the relay's STUN responder sees. When the
machine's own addresses change, the responder is asked again.
"""

import ipaddress
import os
import time
from collections.abc import Callable, Sequence
from typing import Self

from conf.errors import NetworkError
from conf.protocol.address import Address, RelayAddress, SocketAddress
from conf.transport.combined import CombinedTransport
from conf.transport.interface import ReceivedDatagram
from conf.transport.local_addresses import find_route_addresses
from conf.transport.relay_settings import Credentials
from conf.transport.stun import STUN_PORT_STEPS, StunClient
from conf.transport.udp import DIRECT, UdpSocket, resolve
from conf.transport.zenoh_transport import RelayTransport

CHECK_S = 2.0  # between looks at this machine's addresses


class TraversalTransport(CombinedTransport):
    """UDP and a relay, with the candidate addresses of the UDP socket."""

    def __init__(
        self,
        udp: UdpSocket,
        relay: RelayTransport,
        *,
        servers: Sequence[SocketAddress] = (),
        clock: Callable[[], float] = time.monotonic,
        find_addresses: Callable[[], Sequence[str]] = find_route_addresses,
    ) -> None:
        """udp, relay : are closed with it; servers : STUN servers"""
        super().__init__(udp, relay, clock=clock)
        self.relay = relay
        self._port = udp.address[1]
        self._servers = servers
        self._find_addresses = find_addresses
        self._local: tuple[str, ...] | None = None
        self._check_at = float("-inf")

    @classmethod
    def wait_at(cls, relay: tuple[str, int] | None, nameplate: str, *, credentials: Credentials | None = None) -> Self:
        """Return the end that waits to be called. relay : host and port, None to be found in the local network"""
        servers = find_stun_servers(relay)
        udp = UdpSocket.bind("", 0)
        return cls(udp, RelayTransport.wait_at(relay, nameplate, credentials=credentials), servers=servers)

    @classmethod
    def call(cls, relay: tuple[str, int] | None, nameplate: str, *, credentials: Credentials | None = None) -> Self:
        """Return an end that calls."""
        servers = find_stun_servers(relay)
        udp = UdpSocket.bind("", 0)
        return cls(udp, RelayTransport.call(relay, nameplate, os.urandom, credentials=credentials), servers=servers)

    @property
    def candidates(self) -> tuple[Address, ...]:
        """The addresses at which this end may be reached directly: seen from outside first, then its own."""
        mapped = [] if self.stun is None else [_socket_address(*address) for address in self.stun.mapped.values()]
        own = [_socket_address(host, self._port) for host in self._local or ()]
        return tuple(dict.fromkeys([*mapped, *own]))

    def path_name(self, address: Address, /) -> str:
        """Return how datagrams reach an address."""
        return self.relay.path_name(address) if isinstance(address, RelayAddress) else DIRECT

    def receive(self, limit: int, /) -> list[ReceivedDatagram]:
        """Return the datagrams that have arrived. Raises NetworkError if this machine cannot receive."""
        self._check_addresses()
        return super().receive(limit)

    def _check_addresses(self) -> None:
        """Ask the STUN servers, at first and when this machine's addresses have changed."""
        now = self._clock()
        if now < self._check_at:
            return
        self._check_at = now + CHECK_S
        found = tuple(self._find_addresses())
        if any(ipaddress.ip_address(server[0]).is_loopback for server in self._servers):
            found += tuple(server[0] for server in self._servers if ipaddress.ip_address(server[0]).is_loopback)
        if found != self._local:
            self._local = found
            self.stun = StunClient(self._servers, os.urandom)


def find_stun_servers(relay: tuple[str, int] | None, /) -> list[SocketAddress]:
    """Return the addresses of a relay's STUN responder, one for each address family; none without a relay.

    Raises NetworkError if the name of the relay has no address.
    """
    if relay is None:
        return []
    host, port = relay
    try:
        found = resolve(host, port + STUN_PORT_STEPS[0])
    except NetworkError as error:
        raise NetworkError(f"no address for the relay {host!r}: check its name, and this network") from error
    first: dict[int, SocketAddress] = {}
    for address in found:
        first.setdefault(len(address), address)
    return list(first.values())


def _socket_address(host: str, port: int) -> SocketAddress:
    return (host, port, 0, 0) if ":" in host else (host, port)
