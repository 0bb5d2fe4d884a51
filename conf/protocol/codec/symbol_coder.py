"""Integers as symbols: a writer and a reader with one interface, so that the syntax above them is written once.

Strategy. Most coded numbers are small, and the context predicts their *scale*: the usual distance from zero. A scale is
an index on a grid of quarter octaves. Each small scale has a trained table with an escape symbol for larger numbers;
above the last table the low bits of a number are coded raw and the rest with the tables. The writer does not always
choose the nearest number: one step nearer to zero costs fewer bits and little precision, and `rd_lambda` is the squared
error (in steps) that one bit may cost.
Source: Sullivan, Wiegand 1998 (rate-distortion optimised quantisation).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from itertools import accumulate
from math import log2

from conf.errors import ProtocolError
from conf.protocol.codec.range_coder import PRECISION, TOTAL, RangeDecoder, RangeEncoder

MAX_TABLE_MAGNITUDE = 20  # the largest magnitude with a frequency of its own
ESCAPE = 2 * MAX_TABLE_MAGNITUDE + 1  # the symbol for larger magnitudes
SCALES_PER_OCTAVE = 4
MAX_BITS = 13  # of any magnitude; more only occurs in an invalid payload
LIMIT = (1 << MAX_BITS) - 1


@dataclass(frozen=True)
class Tables:
    """For each scale the cumulative frequencies of -20..20 and the escape, and the cost of each in bits."""

    cumulative: list[list[int]]
    cost: list[list[float]]

    @classmethod
    def from_frequencies(cls, frequencies: Sequence[Sequence[int]]) -> "Tables":
        """Return the tables. Raises ValueError unless all frequencies are positive and sum to TOTAL at each scale."""
        cumulative = [_accumulate(row) for row in frequencies]
        return cls(cumulative, [[PRECISION - log2(frequency) for frequency in row] for row in frequencies])

    @cached_property
    def last(self) -> int:
        """The largest scale with a table."""
        return len(self.cumulative) - 1


def _accumulate(frequencies: Sequence[int]) -> list[int]:
    if min(frequencies) <= 0:
        raise ValueError("a frequency is not positive")
    cumulative = [0, *accumulate(frequencies)]
    if cumulative[-1] != TOTAL:
        raise ValueError(f"frequencies sum to {cumulative[-1]}, not {TOTAL}")
    return cumulative


@cache
def uniform_table(count: int) -> list[int]:
    """Return the cumulative frequencies of `count` symbols that are equally likely, up to rounding."""
    return [TOTAL * i // count for i in range(count + 1)]


def weighted_table(weights: Sequence[float]) -> list[int]:
    """Return the cumulative frequencies of symbols with these weights; symbol 0 gets the rounding remainder."""
    total = sum(weights)
    frequencies = [1 + int((TOTAL - len(weights)) * weight / total) for weight in weights]
    frequencies[0] += TOTAL - sum(frequencies)
    return _accumulate(frequencies)


_BITS = [uniform_table(1 << count) for count in range(9)]


class SymbolWriter:
    """Turn symbols into bytes. bits : information written so far"""

    def __init__(self, *, rd_lambda: float) -> None:
        self._rd_lambda = rd_lambda
        self._range = RangeEncoder()
        self.bits = 0.0

    def symbol(self, cumulative: Sequence[int], value: int) -> int:
        """Write one symbol."""
        self.bits += PRECISION - log2(cumulative[value + 1] - cumulative[value])
        self._range.write(cumulative, value)
        return value

    def number(self, tables: Tables, scale: int, target: float) -> int:
        """Write and return the integer near `target` with the lowest rate-distortion cost."""
        value = max(-LIMIT, min(LIMIT, round(target)))
        if value and scale <= tables.last and -MAX_TABLE_MAGNITUDE <= value <= MAX_TABLE_MAGNITUDE:
            value = self._rate_distortion_choice(tables.cost[scale], target, value)
        return _code_number(self, tables, scale, value)

    def finish(self) -> bytes:
        """Return the payload."""
        return self._range.finish()

    def _rate_distortion_choice(self, cost: list[float], target: float, nearest: int) -> int:
        smaller = nearest - 1 if nearest > 0 else nearest + 1
        extra_error = (target - smaller) ** 2 - (target - nearest) ** 2
        saved_bits = cost[nearest + MAX_TABLE_MAGNITUDE] - cost[smaller + MAX_TABLE_MAGNITUDE]
        return smaller if extra_error < self._rd_lambda * saved_bits else nearest


class SymbolReader:
    """Turn bytes back into symbols. Every method may raise ProtocolError."""

    def __init__(self, data: bytes) -> None:
        self._range = RangeDecoder(data)

    def symbol(self, cumulative: Sequence[int], value: int = 0) -> int:
        """Read one symbol."""
        return self._range.read(cumulative)

    def number(self, tables: Tables, scale: int, target: float = 0.0) -> int:
        """Read an integer."""
        return _code_number(self, tables, scale, 0)

    def finish(self) -> None:
        """Check that all bytes were read and none is missing."""
        self._range.finish()


# Both directions: a writer returns what it wrote, a reader ignores the value passed.
SymbolCoder = SymbolWriter | SymbolReader


def _code_number(coder: SymbolCoder, tables: Tables, scale: int, value: int) -> int:
    if scale > tables.last:
        shift = -(-(scale - tables.last) // SCALES_PER_OCTAVE)
        half = 1 << shift >> 1
        high = _code_number(coder, tables, scale - shift * SCALES_PER_OCTAVE, value + half >> shift)
        return (high << shift | _code_bits(coder, shift, value + half)) - half
    fits = -MAX_TABLE_MAGNITUDE <= value <= MAX_TABLE_MAGNITUDE
    symbol = coder.symbol(tables.cumulative[scale], value + MAX_TABLE_MAGNITUDE if fits else ESCAPE)
    return symbol - MAX_TABLE_MAGNITUDE if symbol != ESCAPE else _code_escaped(coder, value)


def _code_escaped(coder: SymbolCoder, value: int) -> int:
    """Code a value beyond the tables: the bit length of what exceeds them, the sign, the bits below the highest."""
    excess = abs(value) - MAX_TABLE_MAGNITUDE
    length = coder.symbol(_BITS[4], excess.bit_length())
    if not 0 < length <= MAX_BITS:
        raise ProtocolError("escape of an impossible length")
    negative = coder.symbol(_BITS[1], int(value < 0))
    magnitude = MAX_TABLE_MAGNITUDE + (1 << length - 1 | _code_bits(coder, length - 1, excess))
    return -magnitude if negative else magnitude


def _code_bits(coder: SymbolCoder, count: int, value: int) -> int:
    """Code the lowest `count` bits of `value` raw, at most 8 at a time, the highest first."""
    bits = 0
    while count:
        part = min(count, 8)
        count -= part
        bits = bits << part | coder.symbol(_BITS[part], value >> count & (1 << part) - 1)
    return bits
