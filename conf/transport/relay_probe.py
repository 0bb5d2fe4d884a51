"""What this machine's network lets through to a relay, and what kind of NAT is between."""

import enum
import os
import socket
import time
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

from conf.errors import NetworkError
from conf.protocol.address import Address, format_address
from conf.transport.local_addresses import find_local_addresses
from conf.transport.relay_settings import Credentials, client_settings, open_zenoh
from conf.transport.stun import STUN_PORT_STEPS, StunClient
from conf.transport.udp import UdpSocket, resolve

STUN_LIMIT_S = 3.0
PROBE_TIMEOUT_S = 2.5  # of each link: enough for a satellite
ABSENT = "the relay {relay} does not answer: check its name and port, and whether this network lets TCP out"
REFUSING = (
    "the relay {relay} answers but opens no session: check the user and password of --relay-password FILE; if they are "
    "right, it is full or of another version"
)


class NatKind(enum.Enum):
    """What is between a socket and a STUN server, as far as two ports of one server can tell."""

    NONE = "none"
    ONE_PORT = "one port"  # the same outside port for both: endpoint- or address-dependent mapping (RFC 4787, 4.1)
    SYMMETRIC = "symmetric"  # another outside port for each destination
    UNKNOWN = "unknown"  # one port of the server has answered
    BLOCKED = "blocked"


@dataclass(frozen=True)
class NatReport:
    """outside : (host, port) that the server's ports have received from; none if none has answered"""

    kind: NatKind
    outside: Sequence[tuple[str, int]]


def classify_nat(
    mapped: Mapping[Address, tuple[str, int]],
    servers: Collection[Address],
    own_hosts: Collection[str],
    own_port: int,
    /,
) -> NatReport:
    """Return the kind of NAT. mapped : server -> outside address of one socket; own_hosts, own_port : of that socket"""
    outside = [mapped[server] for server in servers if server in mapped]
    if not outside:
        return NatReport(NatKind.BLOCKED, outside)
    if all(host in own_hosts and port == own_port for host, port in outside):
        return NatReport(NatKind.NONE, outside)
    if len(outside) < len(servers) or len(servers) < 2:
        return NatReport(NatKind.UNKNOWN, outside)
    return NatReport(NatKind.ONE_PORT if len(set(outside)) == 1 else NatKind.SYMMETRIC, outside)


def probe_nat(relay: tuple[str, int], /) -> NatReport:
    """Ask both STUN ports of a relay from one socket. Blocks for up to 3 s. Raises NetworkError without an address."""
    host, port = relay
    first = resolve(host, port)[0]
    servers: list[Address] = [_with_port(first, port + step) for step in STUN_PORT_STEPS]
    client = StunClient(servers, os.urandom)
    with UdpSocket.bind("::" if len(first) == 4 else "0.0.0.0", 0) as link:
        own_hosts = {*find_local_addresses(), "127.0.0.1", "::1"}
        end = time.monotonic() + STUN_LIMIT_S
        while not client.is_done and (now := time.monotonic()) < end:
            _send(link, client.datagrams_to_send(now))
            link.wait(0.05)
            for data, address, _ in link.receive():
                client.receive_datagram(data, address)
        return classify_nat(client.mapped, servers, own_hosts, link.address[1])


def probe_links(relay: tuple[str, int], credentials: Credentials | None = None, /) -> frozenset[str]:
    """Return what carries a session to a relay, "udp" and "tcp"; nothing if it does not answer or refuses."""
    import zenoh

    try:
        session = open_zenoh(client_settings(relay, credentials), PROBE_TIMEOUT_S)
    except zenoh.ZError:
        return frozenset()
    try:
        return frozenset(link.dst.partition("/")[0] for link in session.info.links())
    finally:
        session.close()


def explain_refusal(relay: tuple[str, int], /) -> str:
    """Return in a sentence why no session with a relay could be opened. Blocks for up to 2.5 s.

    Somebody must answer over TCP to be called refusing; a wrong password where TCP is blocked is not told apart.
    """
    try:
        socket.create_connection(relay, PROBE_TIMEOUT_S).close()
    except (OSError, ValueError):
        return ABSENT.format(relay=format_address(relay))
    return REFUSING.format(relay=format_address(relay))


def _with_port(address: Address, port: int) -> Address:
    return (str(address[0]), port, int(address[2]), int(address[3])) if len(address) == 4 else (str(address[0]), port)


def _send(link: UdpSocket, datagrams: list[tuple[bytes, Address]]) -> None:
    try:
        link.send(datagrams)
    except NetworkError:  # no way out is an answer too: none will come
        return
