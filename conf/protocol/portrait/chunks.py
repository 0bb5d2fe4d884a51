"""The two message bodies of the portrait transfer: a chunk of an object, and an acknowledgement.

    chunk  object u16, chunk size / 4 u8, index u8, object size u16, data
    ack    receiver id u16, count u8, count complete objects u16 each, then per partial object: u16, chunks u8, bitmap

Integers are big-endian. Bit i of a bitmap, the lowest bit of each byte first, is set if chunk i has arrived.
"""

import struct
from dataclasses import dataclass

from conf.errors import ProtocolError

MAX_OBJECT_BYTES = 12_288
MAX_CHUNKS = 255
CHUNK_SIZE_UNIT = 4
MAX_COMPLETE = 32
MAX_PARTIAL = 4
_CHUNK = struct.Struct(">HBBH")
_ACK = struct.Struct(">HB")
_PARTIAL = struct.Struct(">HB")
CHUNK_HEADER_BYTES = _CHUNK.size


@dataclass(frozen=True)
class Chunk:
    """One part of an object.

    object_number : modulo 65536
    size : bytes of every chunk of this object but the last
    index : position among the chunks, from 0
    object_size : bytes
    """

    object_number: int
    size: int
    index: int
    object_size: int
    data: bytes


@dataclass(frozen=True)
class Ack:
    """What a receiver has.

    receiver_id : differs if the receiver has started again and has nothing
    complete : numbers of objects
    partial : (object number, indices of the chunks that have arrived)
    """

    receiver_id: int
    complete: tuple[int, ...]
    partial: tuple[tuple[int, frozenset[int]], ...]


def chunk_count(object_size: int, size: int) -> int:
    """Return the number of chunks of `size` bytes that an object needs."""
    return -(-object_size // size)


def encode_chunk(chunk: Chunk) -> bytes:
    """Return the bytes of a chunk."""
    return _CHUNK.pack(chunk.object_number, chunk.size // CHUNK_SIZE_UNIT, chunk.index, chunk.object_size) + chunk.data


def decode_chunk(data: bytes) -> Chunk:
    """Return a chunk whose numbers are consistent. Raises ProtocolError."""
    if len(data) <= _CHUNK.size:
        raise ProtocolError("a chunk without data")
    object_number, units, index, object_size = _CHUNK.unpack_from(data)
    size = units * CHUNK_SIZE_UNIT
    if not size or not 0 < object_size <= MAX_OBJECT_BYTES:
        raise ProtocolError("a chunk size or object size out of range")
    count = chunk_count(object_size, size)
    if count > MAX_CHUNKS or index >= count:
        raise ProtocolError("a chunk beyond the end of its object")
    expected = size if index < count - 1 else object_size - size * (count - 1)
    if len(data) - _CHUNK.size != expected:
        raise ProtocolError("a chunk of the wrong length")
    return Chunk(object_number, size, index, object_size, data[_CHUNK.size :])


def encode_ack(ack: Ack) -> bytes:
    """Return the bytes of an acknowledgement."""
    complete = struct.pack(f">{len(ack.complete)}H", *ack.complete)
    parts = [_ACK.pack(ack.receiver_id, len(ack.complete)), complete]
    for number, indices in ack.partial:
        count = max(indices, default=0) + 1
        bitmap = sum(1 << index for index in indices)
        parts.append(_PARTIAL.pack(number, count) + bitmap.to_bytes((count + 7) // 8, "little"))
    return b"".join(parts)


def decode_ack(data: bytes) -> Ack:
    """Return an acknowledgement. Raises ProtocolError."""
    if len(data) < _ACK.size:
        raise ProtocolError("an acknowledgement cut off")
    receiver_id, count = _ACK.unpack_from(data)
    at = _ACK.size + 2 * count
    if count > MAX_COMPLETE or len(data) < at:
        raise ProtocolError("an acknowledgement with too many objects, or cut off")
    complete = struct.unpack_from(f">{count}H", data, _ACK.size)
    partial: list[tuple[int, frozenset[int]]] = []
    while at < len(data):
        if len(partial) == MAX_PARTIAL or at + _PARTIAL.size > len(data):
            raise ProtocolError("an acknowledgement with too many objects, or cut off")
        number, chunks = _PARTIAL.unpack_from(data, at)
        end = at + _PARTIAL.size + (chunks + 7) // 8
        if end > len(data):
            raise ProtocolError("an acknowledgement cut off")
        bitmap = int.from_bytes(data[at + _PARTIAL.size : end], "little")
        partial.append((number, frozenset(i for i in range(chunks) if bitmap >> i & 1)))
        at = end
    return Ack(receiver_id, complete, tuple(partial))
