"""The network address of a peer: as the socket calls give it, and as a user types it."""

import re
from ipaddress import AddressValueError, IPv6Address
from typing import NamedTuple

DEFAULT_PORT = 5005
MAX_PORT = 65535
DEFAULT_RELAY_PORT = 7447  # that of zenoh


class RelayAddress(NamedTuple):
    """A peer that is reached through a relay.

    nameplate : the public number of the call
    member : the caller's random name, "" for the end that waits
    """

    nameplate: str
    member: str


# (host, port) for IPv4; (host, port, flow info, scope id) for IPv6.
SocketAddress = tuple[str, int] | tuple[str, int, int, int]
Address = SocketAddress | RelayAddress

# [HOST]:PORT, HOST:PORT, or an IPv6 address without brackets, which has no port
_TYPED = re.compile(
    r"(?:\[(?P<bracketed>[^\]]+)\]|(?P<bare>[^:\[\]]*:[^\[\]]*:[^\[\]]*)|(?P<host>[^:\[\]]+))(?::(?P<port>\d{1,5}))?"
)


def format_address(address: Address, /) -> str:
    """Return an address as a user types it: host:port, or [host]:port for IPv6; no host stands for all addresses.

    A peer behind a relay has none: "relay", for a caller with its random name, as in "relay/qxw4kbr2".
    """
    if isinstance(address, RelayAddress):
        return f"relay/{address.member}" if address.member else "relay"
    host, port = address[:2]
    return f"[{host}]:{port}" if ":" in host else f"{host or '0.0.0.0'}:{port}"


def typed_address(host: str, port: int, /, *, default_port: int = DEFAULT_PORT) -> str:
    """Return an address as somebody at another machine types it: the default port is left out."""
    return host if port == default_port else format_address((host, port))


def host_of(address: Address, /) -> str:
    """Return the host of an address; all peers behind a relay count as one, whatever names they choose."""
    return "the relay" if isinstance(address, RelayAddress) else address[0]


def parse_address(text: str, /, *, default_port: int = DEFAULT_PORT) -> tuple[str, int]:
    """Return host and port of HOST, HOST:PORT, [HOST]:PORT or [HOST]; without a port the default one.

    Raises ValueError, with a message for the user.
    """
    host, port = _host_and_port(text, default_port)
    if port == 0:
        raise ValueError(f"{text} names no port: give the one that the receiver shows")
    return host, port


def parse_listen_address(text: str, /, *, default_port: int = DEFAULT_PORT) -> tuple[str, int]:
    """Return host and port as `parse_address`; a port alone, or :PORT, stands for every address of this machine.

    Port 0 is any free one. Raises ValueError, with a message for the user.
    """
    port = text.removeprefix(":")
    if port.isdecimal():
        if int(port) > MAX_PORT:
            raise ValueError(f"{text} is no port: give one up to {MAX_PORT}")
        return "", int(port)
    return _host_and_port(text, default_port)


def _host_and_port(text: str, default_port: int) -> tuple[str, int]:
    match = _TYPED.fullmatch(text)
    if match is None or int(match["port"] or default_port) > MAX_PORT:
        raise ValueError(f"{text} is not HOST:PORT; an IPv6 address is written [HOST]:PORT")
    host = match["bracketed"] or match["host"] or match["bare"]
    if ":" in host:
        try:
            IPv6Address(host)
        except AddressValueError:
            raise ValueError(f"{text} is neither HOST:PORT nor an IPv6 address") from None
    return host, int(match["port"] or default_port)
