"""The outer framing of datagrams. WIRE.md describes it.

Strategy. Every datagram is one msgpack array of small integers and one `bin`. Only the shortest msgpack form of each is
valid, so that a datagram has one encoding, and a parser of fixed shape is simpler and faster than msgpack's:

    data       94 VV ss cc.. c4 nn ....    [version, session 0..127, counter, bin(sealed body)]
    handshake  93 VV kk c4 nn ....         [version, kind, bin(fields, CRC-32)]

The counter is cut to its low seven bits if the peer's newest counter is known to be near enough to restore it, as in
QUIC (RFC 9000, A.3). The CRC distinguishes damage from a wrong code. It protects against no attacker.
"""

import zlib
from dataclasses import dataclass
from enum import IntEnum
from struct import Struct
from typing import Any

from conf.protocol.session.drop_reasons import DatagramError, DropReason
from conf.protocol.session.sequence import unwrap

VERSION = 3
MAX_DATAGRAM = 1200
TAG_BYTES = 8
MAX_OVERHEAD = 19  # bytes that framing and seal add to a body at most
MIN_DATAGRAM = 10
MAX_SESSION = 127
MAX_COUNTER = 0xFFFFFFFF
SHORT_COUNTER_REACH = 64  # how far behind the peer's newest counter may be for the short form
LOW_BITS = 0x7F

DATA_PREFIX, HANDSHAKE_PREFIX = 0x94, 0x93
BIN8, BIN16 = 0xC4, 0xC5
# msgpack's unsigned integers: prefix -> (bytes, smallest value that needs them)
_WIDTHS = {0xCC: (1, 0x80), 0xCD: (2, 0x100), 0xCE: (4, 0x10000)}


class Kind(IntEnum):
    """The kinds of handshake datagrams, in the order of the handshake."""

    HELLO = 0
    RETRY = 1
    ANSWER = 2
    CONFIRM = 3
    DONE = 4
    REFUSED = 5
    UNKNOWN = 6


# The fields of each kind, big-endian. A request is never shorter than its answers.
FIELDS = {
    Kind.HELLO: Struct(">8s8s32s"),  # attempt, cookie or zeros, the sender's SPAKE2 share
    Kind.RETRY: Struct(">8s8s"),  # attempt, cookie
    Kind.ANSWER: Struct(">8s32s"),  # attempt, the receiver's SPAKE2 share
    Kind.CONFIRM: Struct(">8sB16s"),  # attempt, 0, proof that the sender knows the key
    Kind.DONE: Struct(">8sB16s"),  # attempt, session, proof that the receiver knows it
    Kind.REFUSED: Struct(">8sBB"),  # attempt, refusal, its number
    Kind.UNKNOWN: Struct(">B"),  # session
}
_KINDS = {int(kind): (kind, fields, fields.size + 4) for kind, fields in FIELDS.items()}


@dataclass(frozen=True, slots=True)
class DataPacket:
    """A sealed datagram, not authenticated yet.

    counter : as on the wire; below 128 it is the low seven bits of the full one
    """

    session: int
    counter: int
    header: bytes
    sealed: bytes


@dataclass(frozen=True, slots=True)
class HandshakePacket:
    """A handshake datagram whose checksum is right: its kind and the fields of FIELDS[kind]."""

    kind: Kind
    fields: tuple[Any, ...]


def parse_datagram(data: bytes) -> DataPacket | HandshakePacket:
    """Return the packet in a datagram. Raises DatagramError, whatever the bytes, and no other exception."""
    if not MIN_DATAGRAM <= len(data) <= MAX_DATAGRAM:
        raise DatagramError(DropReason.SIZE)
    if data[0] == DATA_PREFIX:
        return _parse_data(data)
    if data[0] == HANDSHAKE_PREFIX:
        return _parse_handshake(data)
    raise DatagramError(DropReason.SYNTAX)


def _parse_data(data: bytes) -> DataPacket:
    if data[1] != VERSION:
        raise DatagramError(DropReason.VERSION)
    session, counter, at = data[2], data[3], 4
    if counter > LOW_BITS:
        width, smallest = _WIDTHS.get(counter, (0, 0))
        at += width
        counter = int.from_bytes(data[4:at])
        if not width or counter < smallest:
            raise DatagramError(DropReason.SYNTAX)
    start = at + 3 if data[at] == BIN16 else at + 2
    size = len(data) - start
    if session > MAX_SESSION or size < TAG_BYTES or data[at:start] != _bin_header(size):
        raise DatagramError(DropReason.SYNTAX)
    return DataPacket(session, counter, data[:start], data[start:])


def _parse_handshake(data: bytes) -> HandshakePacket:
    if data[1] != VERSION:
        raise DatagramError(DropReason.VERSION)
    kind, fields, size = _KINDS.get(data[2], (Kind.UNKNOWN, FIELDS[Kind.UNKNOWN], -1))
    if len(data) != 5 + size or data[3] != BIN8 or data[4] != size:
        raise DatagramError(DropReason.SYNTAX)
    if zlib.crc32(data[:-4]) != int.from_bytes(data[-4:]):
        raise DatagramError(DropReason.CHECKSUM)
    return HandshakePacket(kind, fields.unpack_from(data, 5))


def handshake_datagram(kind: Kind, *fields: bytes | int) -> bytes:
    """Return the bytes of a handshake datagram with the fields of FIELDS[kind]."""
    body = FIELDS[kind].pack(*fields)
    data = bytes((HANDSHAKE_PREFIX, VERSION, kind, BIN8, len(body) + 4)) + body
    return data + zlib.crc32(data).to_bytes(4)


def data_header(session: int, counter: int, acknowledged: int, body_bytes: int) -> bytes:
    """Return all of a data datagram that precedes its sealed body.

    acknowledged : the newest counter that the peer is known to have received, -1 if none
    Raises ValueError if the datagram would exceed 1,200 B.
    """
    if counter - acknowledged <= SHORT_COUNTER_REACH:
        counter &= LOW_BITS
    header = bytes((DATA_PREFIX, VERSION, session)) + _counter_bytes(counter) + _bin_header(body_bytes + TAG_BYTES)
    if len(header) + body_bytes + TAG_BYTES > MAX_DATAGRAM:
        raise ValueError(f"a body of {body_bytes} B does not fit a datagram of {MAX_DATAGRAM} B")
    return header


def restore_counter(on_wire: int, highest: int) -> int:
    """Return the full counter of a datagram.

    on_wire : as parsed; below 128 only the low seven bits
    highest : the highest authenticated counter, -1 if none
    """
    return on_wire if on_wire > LOW_BITS else unwrap(on_wire, bits=7, expected=highest + 1)


def _counter_bytes(counter: int) -> bytes:
    if counter <= LOW_BITS:
        return bytes((counter,))
    prefix, width = next((prefix, width) for prefix, (width, _) in _WIDTHS.items() if counter < 1 << 8 * width)
    return bytes((prefix,)) + counter.to_bytes(width)


def _bin_header(size: int) -> bytes:
    return bytes((BIN8, size)) if size < 0x100 else bytes((BIN16,)) + size.to_bytes(2)
