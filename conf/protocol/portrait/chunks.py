"""The two bodies of the portrait's transfer: a piece of an object, and what the receiver has of them.

    piece   number u16, grain u8 (piece size / 4), index u8, total u16 bytes, data
    answer  token u16, finished u8, finished x number u16, then for each unfinished: number u16, count u8, bits

Integers are big-endian. Bit i of the bits, the lowest first in each byte, is set when piece i is there.
"""

import struct
from dataclasses import dataclass

from conf.errors import ProtocolError

MAX_OBJECT = 12_288
MAX_PIECES = 255
CHUNK_SIZE_UNIT = 4
MAX_FINISHED = 32
MAX_UNFINISHED = 4
_PIECE = struct.Struct(">HBBH")
_START = struct.Struct(">HB")
_UNFINISHED = struct.Struct(">HB")
PIECE_HEADER = _PIECE.size


@dataclass(frozen=True)
class Chunk:
    """One part of an object.

    number : of the object, modulo 65536
    size : of every piece of this object but the last, bytes
    index : which piece
    total : size of the object, bytes
    """

    number: int
    size: int
    index: int
    object_size: int
    data: bytes


@dataclass(frozen=True)
class Ack:
    """What a receiver has.

    token : differs when the receiver has begun anew and has nothing
    finished : numbers of objects that are whole
    unfinished : (number, indices of the pieces that are there)
    """

    token: int
    complete: tuple[int, ...]
    partial: tuple[tuple[int, frozenset[int]], ...]


def piece_count(object_size: int, size: int) -> int:
    """Return into how many pieces of a size an object is cut."""
    return -(-object_size // size)


def encode_piece(piece: Chunk) -> bytes:
    """Return the bytes of a piece."""
    return _PIECE.pack(piece.number, piece.size // CHUNK_SIZE_UNIT, piece.index, piece.object_size) + piece.data


def decode_piece(data: bytes) -> Chunk:
    """Return a piece whose numbers fit each other. Raises ProtocolError."""
    if len(data) <= _PIECE.size:
        raise ProtocolError("a piece without data")
    number, grain, index, total = _PIECE.unpack_from(data)
    size = grain * CHUNK_SIZE_UNIT
    if not size or not 0 < total <= MAX_OBJECT:
        raise ProtocolError("a piece of nothing, or of too much")
    count = piece_count(total, size)
    if count > MAX_PIECES or index >= count:
        raise ProtocolError("a piece beyond the end of its object")
    expected = size if index < count - 1 else total - size * (count - 1)
    if len(data) - _PIECE.size != expected:
        raise ProtocolError("a piece of the wrong length")
    return Chunk(number, size, index, total, data[_PIECE.size :])


def encode_answer(answer: Ack) -> bytes:
    """Return the bytes of an answer."""
    finished = struct.pack(f">{len(answer.complete)}H", *answer.complete)
    parts = [_START.pack(answer.token, len(answer.complete)), finished]
    for number, indices in answer.partial:
        count = max(indices, default=0) + 1
        bits = sum(1 << index for index in indices)
        parts.append(_UNFINISHED.pack(number, count) + bits.to_bytes((count + 7) // 8, "little"))
    return b"".join(parts)


def decode_answer(data: bytes) -> Ack:
    """Return an answer. Raises ProtocolError."""
    if len(data) < _START.size:
        raise ProtocolError("an answer cut off")
    token, count = _START.unpack_from(data)
    at = _START.size + 2 * count
    if count > MAX_FINISHED or len(data) < at:
        raise ProtocolError("an answer with too many objects, or cut off")
    finished = struct.unpack_from(f">{count}H", data, _START.size)
    unfinished: list[tuple[int, frozenset[int]]] = []
    while at < len(data):
        if len(unfinished) == MAX_UNFINISHED or at + _UNFINISHED.size > len(data):
            raise ProtocolError("an answer with too many objects, or cut off")
        number, pieces = _UNFINISHED.unpack_from(data, at)
        end = at + _UNFINISHED.size + (pieces + 7) // 8
        if end > len(data):
            raise ProtocolError("an answer cut off")
        bits = int.from_bytes(data[at + _UNFINISHED.size : end], "little")
        unfinished.append((number, frozenset(i for i in range(pieces) if bits >> i & 1)))
        at = end
    return Ack(token, finished, tuple(unfinished))
