"""STUN Binding (RFC 8489): ask a server from which address one's datagrams come. Sans-IO.

Strategy. A request is a header without attributes, an answer a header with XOR-MAPPED-ADDRESS. No credentials and no
FINGERPRINT: an answer counts if it carries the transaction id, 12 random bytes, of a request to its sender.
Requests are repeated, as any datagram may be lost.
"""

import ipaddress
import struct
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from conf.protocol.address import Address

HEADER = struct.Struct(">HHI12s")  # type, length of the attributes, magic cookie, transaction id
ATTRIBUTE = struct.Struct(">HH")  # type, length without padding
MAGIC_COOKIE = 0x2112A442
BINDING_REQUEST, BINDING_SUCCESS = 0x0001, 0x0101
XOR_MAPPED_ADDRESS = 0x0020
FAMILY_SIZES = {1: 4, 2: 16}  # family -> bytes of the address: IPv4, IPv6
TRANSACTION_BYTES = 12
# From a relay's port to those of its STUN responder. Two, as a NAT may map each destination to a port of its own: that
# shows only in a second answer.
STUN_PORT_STEPS = (1, 2)
# RFC 8489, 6.2.1 begins with 500 ms; a lost request should not delay a call by more than a fifth of a second.
FIRST_RETRY_S = 0.2
MAX_REQUESTS = 7  # RFC 8489, 6.2.1


def encode_request(transaction: bytes, /) -> bytes:
    """Return a Binding request. transaction : 12 random bytes"""
    return HEADER.pack(BINDING_REQUEST, 0, MAGIC_COOKIE, transaction)


def decode_request(data: bytes, /) -> bytes | None:
    """Return the transaction id of a Binding request, None if the bytes are something else."""
    message = _header(data, BINDING_REQUEST)
    return message[0] if message else None


def encode_response(transaction: bytes, address: Address, /) -> bytes:
    """Return the answer to a request: the address it came from."""
    host = ipaddress.ip_address(address[0].partition("%")[0])
    family = {4: 1, 6: 2}[host.version]
    port = int(address[1]) ^ (MAGIC_COOKIE >> 16)
    value = struct.pack(">xBH", family, port) + _xor(host.packed, transaction)
    attribute = ATTRIBUTE.pack(XOR_MAPPED_ADDRESS, len(value)) + value
    return HEADER.pack(BINDING_SUCCESS, len(attribute), MAGIC_COOKIE, transaction) + attribute


def decode_response(data: bytes, /) -> tuple[bytes, tuple[str, int]] | None:
    """Return transaction id, host and port of a Binding success response, None if the bytes are something else."""
    message = _header(data, BINDING_SUCCESS)
    if message is None:
        return None
    transaction, attributes = message
    while len(attributes) >= ATTRIBUTE.size:
        kind, length = ATTRIBUTE.unpack_from(attributes)
        value = attributes[ATTRIBUTE.size : ATTRIBUTE.size + length]
        attributes = attributes[ATTRIBUTE.size + length + -length % 4 :]
        if kind == XOR_MAPPED_ADDRESS:
            address = _mapped_address(value, transaction)
            return (transaction, address) if address and len(value) == length else None
    return None


@dataclass
class _Request:
    server: Address
    transaction: bytes
    due: float
    sent: int = 0


class StunClient:
    """Ask servers for the outside address of one socket.

    mapped : server -> (host, port) from which the server has received our request
    """

    def __init__(self, servers: Sequence[Address], random: Callable[[int], bytes]) -> None:
        """servers : resolved addresses as the socket reports them; random : n -> n random bytes"""
        self.mapped: dict[Address, tuple[str, int]] = {}
        self._requests = [_Request(server, random(TRANSACTION_BYTES), float("-inf")) for server in servers]

    @property
    def outside_address(self) -> tuple[str, int] | None:
        """The first outside address that is known."""
        return next(iter(self.mapped.values()), None)

    @property
    def is_done(self) -> bool:
        """Whether no request will be sent any more."""
        return all(self._is_over(request) for request in self._requests)

    def datagrams_to_send(self, now: float, /) -> list[tuple[bytes, Address]]:
        """Return the requests that are due. The time between two to one server doubles."""
        datagrams = []
        for request in self._requests:
            if not self._is_over(request) and now >= request.due:
                datagrams.append((encode_request(request.transaction), request.server))
                request.due = now + FIRST_RETRY_S * 2**request.sent
                request.sent += 1
        return datagrams

    def receive_datagram(self, data: bytes, address: Address, /) -> bool:
        """Process a datagram. Returns whether it answers a request of ours, so that nobody else need look at it."""
        response = decode_response(data)
        if response is None:
            return False
        transaction, mapped = response
        for request in self._requests:
            if transaction == request.transaction and address[:2] == request.server[:2]:
                self.mapped.setdefault(request.server, mapped)
                return True
        return False

    def _is_over(self, request: _Request) -> bool:
        return request.server in self.mapped or request.sent >= MAX_REQUESTS


def _header(data: bytes, kind: int) -> tuple[bytes, bytes] | None:
    """Return transaction id and attributes of a message of one kind."""
    if len(data) < HEADER.size:
        return None
    found, length, cookie, transaction = HEADER.unpack_from(data)
    is_valid = found == kind and cookie == MAGIC_COOKIE and length == len(data) - HEADER.size and length % 4 == 0
    return (transaction, data[HEADER.size :]) if is_valid else None


def _mapped_address(value: bytes, transaction: bytes) -> tuple[str, int] | None:
    if len(value) < 4 or len(value) != 4 + FAMILY_SIZES.get(value[1], -1):
        return None
    (port,) = struct.unpack_from(">H", value, 2)
    return str(ipaddress.ip_address(_xor(value[4:], transaction))), port ^ (MAGIC_COOKIE >> 16)


def _xor(address: bytes, transaction: bytes) -> bytes:
    """Return an address combined with cookie and transaction id, so that no gateway rewrites it (RFC 8489, 14.2)."""
    mask = MAGIC_COOKIE.to_bytes(4, "big") + transaction
    return bytes(a ^ b for a, b in zip(address, mask, strict=False))
