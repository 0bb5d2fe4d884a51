"""The addresses at which a participant may be reached directly: the body that announces them, and which are tried.

0e | answer wanted 1 bit, revision 7 bits | newest revision received from the peer
   | IPv4 addresses 4 bits, IPv6 addresses 4 bits
   | each IPv4 address: host 4 B, port 2 B | each IPv6 address: host 16 B, port 2 B
"""

import ipaddress
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise

from conf.errors import ProtocolError
from conf.protocol.address import Address, RelayAddress, SocketAddress

PATH_CANDIDATES = 0x0E  # kind of body, see WIRE.md
MAX_CANDIDATES = 8
MAX_REVISION = 127
MIN_PORT = 1024  # no probe goes to the ports of DNS, NTP and the like
_HEADER_BYTES, _V4_BYTES, _V6_BYTES = 3, 6, 18
_PORT_BYTES = 2
_WANTED = 0x80


@dataclass(frozen=True)
class PathCandidates:
    """The addresses of who sends it.

    revision : 1 to MAX_REVISION, of these addresses; seen : newest revision received from the peer, 0 for none
    wanted : whether the peer is asked to send its own, because it is not known to have received this revision
    """

    revision: int
    seen: int
    wanted: bool
    addresses: tuple[SocketAddress, ...]


def encode_candidates(candidates: PathCandidates, /) -> bytes:
    """Return the bytes after the kind; IPv4 addresses come first."""
    packed = [ipaddress.ip_address(host).packed + port.to_bytes(_PORT_BYTES) for host, port, *_ in candidates.addresses]
    packed.sort(key=len)
    v4 = sum(len(address) == _V4_BYTES for address in packed)
    counts = v4 << 4 | len(packed) - v4
    first = candidates.revision | (_WANTED if candidates.wanted else 0)
    return b"".join((bytes((first, candidates.seen, counts)), *packed))


def decode_candidates(data: bytes, /) -> PathCandidates:
    """Return the candidates in the bytes after the kind, usable or not. Raises ProtocolError."""
    if len(data) < _HEADER_BYTES:
        raise ProtocolError("path candidates cut off")
    first, seen, counts = data[:_HEADER_BYTES]
    v4, v6 = counts >> 4, counts & 15
    v6_begin = _HEADER_BYTES + v4 * _V4_BYTES
    if not first & ~_WANTED or seen > MAX_REVISION:
        raise ProtocolError("path candidates with a revision out of range")
    if len(data) != v6_begin + v6 * _V6_BYTES or v4 + v6 > MAX_CANDIDATES:
        raise ProtocolError("path candidates of a wrong length")
    begins = [*range(_HEADER_BYTES, v6_begin, _V4_BYTES), *range(v6_begin, len(data), _V6_BYTES), len(data)]
    addresses = tuple(_address(data[begin:end]) for begin, end in pairwise(begins))
    return PathCandidates(first & ~_WANTED, seen, bool(first & _WANTED), addresses)


def usable_candidates(addresses: Iterable[Address], /, *, loopback: bool) -> tuple[SocketAddress, ...]:
    """Return the different addresses that stand for one machine each, at most MAX_CANDIDATES.

    loopback : whether this machine itself is one of them
    """
    usable = [a for a in addresses if not isinstance(a, RelayAddress) and is_usable(a, loopback=loopback)]
    return tuple(dict.fromkeys(usable))[:MAX_CANDIDATES]


def has_loopback(addresses: Sequence[SocketAddress], /) -> bool:
    """Return whether one of the addresses is this machine's own."""
    return any(ipaddress.ip_address(address[0]).is_loopback for address in addresses)


def is_usable(address: SocketAddress, /, *, loopback: bool) -> bool:
    """Return whether an address may be probed: of one machine, in a network beyond the next link, at a high port."""
    host, port = address[:2]
    try:
        ip = ipaddress.ip_address(host)
    except ValueError:
        return False
    if ip.is_loopback:
        return loopback and port >= MIN_PORT
    mapped = isinstance(ip, ipaddress.IPv6Address) and ip.ipv4_mapped is not None
    is_nobody = ip.is_multicast or ip.is_unspecified or ip.is_link_local or ip.is_reserved or mapped
    is_this_network = ip.version == 4 and ip.packed[0] == 0  # RFC 1122, 3.2.1.3
    return port >= MIN_PORT and not is_nobody and not is_this_network


def _address(data: bytes) -> SocketAddress:
    host, port = str(ipaddress.ip_address(data[:-_PORT_BYTES])), int.from_bytes(data[-_PORT_BYTES:])
    return (host, port) if len(data) == _V4_BYTES else (host, port, 0, 0)
