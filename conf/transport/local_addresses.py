"""Addresses and ports of this machine at which others can call it."""

import ipaddress
import socket
from collections.abc import Iterable

from conf.errors import NetworkError
from conf.transport.udp import UdpSocket

# Reserved for documentation (RFC 5737, RFC 3849): nobody's. A datagram socket that is connected there sends nothing,
# but the system chooses the local address of the default route.
_ANYWHERE = ((socket.AF_INET, "192.0.2.1"), (socket.AF_INET6, "2001:db8::1"))
_PORT = 9


def find_local_addresses() -> tuple[str, ...]:
    """Return the addresses of this machine in its networks, that of the default route first; none without a network."""
    return usable_addresses([*_of_default_route(), *_of_host_name()])


def find_route_addresses() -> tuple[str, ...]:
    """Return the addresses of the default routes of IPv4 and IPv6, without asking anybody."""
    return usable_addresses(_of_default_route())


def is_port_free(port: int, /) -> bool:
    """Return whether no other program listens on a UDP port of this machine."""
    try:
        with UdpSocket.bind("", port):
            return True
    except NetworkError:
        return False


def usable_addresses(addresses: Iterable[str], /) -> tuple[str, ...]:
    """Return the different addresses that another machine can type: neither loopback nor link-local ones."""
    usable = []
    for text in addresses:
        address = ipaddress.ip_address(text.partition("%")[0])
        if not (address.is_loopback or address.is_link_local or address.is_unspecified or address.is_multicast):
            usable.append(str(address))
    return tuple(dict.fromkeys(usable))


def _of_default_route() -> Iterable[str]:
    for family, address in _ANYWHERE:
        try:
            with socket.socket(family, socket.SOCK_DGRAM) as handle:
                handle.connect((address, _PORT))
                yield str(handle.getsockname()[0])
        except OSError:  # no such network
            continue


def _of_host_name() -> Iterable[str]:
    try:
        found = socket.getaddrinfo(socket.gethostname(), None, type=socket.SOCK_DGRAM)
    except (OSError, UnicodeError):
        return
    for family, *_, address in found:
        if family in (socket.AF_INET, socket.AF_INET6):
            yield str(address[0])
