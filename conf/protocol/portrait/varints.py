"""Lists of small signed numbers in about a byte each: zigzag, seven bits a byte."""

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from conf.errors import ProtocolError

MAX_BYTES = 3  # a number: 21 bits


def encode_numbers(numbers: Iterable[int], /) -> bytes:
    """Return the bytes of numbers of at most 20 bits; larger ones are cut off."""
    data = bytearray()
    for number in numbers:
        number = max(-(1 << 19), min((1 << 19), int(number)))
        rest = (number << 1) ^ (number >> 31)
        while rest > 0x7F:
            data.append(rest & 0x7F | 0x80)
            rest >>= 7
        data.append(rest)
    return bytes(data)


def decode_numbers(data: bytes, count: int, /) -> NDArray[np.int64]:
    """Return exactly `count` numbers. Raises ProtocolError if the bytes hold others."""
    numbers: list[int] = []
    value = length = 0
    for byte in data:
        value |= (byte & 0x7F) << 7 * length
        length += 1
        if byte < 0x80:
            numbers.append((value >> 1) ^ -(value & 1))
            value = length = 0
        elif length == MAX_BYTES:
            raise ProtocolError("a number that is too long")
    if length or len(numbers) != count:
        raise ProtocolError(f"{len(numbers)} numbers where {count} belong")
    return np.array(numbers, dtype=np.int64)
