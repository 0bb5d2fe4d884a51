"""Whole numbers as symbols: a Writer and a Reader of one shape, so that the syntax above them is written only once.

Strategy. What is coded is nearly always a small number around zero whose *scale* the context tells: how far from zero
it usually lies. A scale is an index on a grid of quarter octaves. Small scales have a trained table each, with an
escape at its end for what is larger; above the last table the number's low bits are sent as they are and the rest with
the tables again. The writer does not always choose the nearest number: one step nearer to zero costs fewer bits and
little precision, and `trade` says how much squared error (in steps) a bit may cost.
Source: Sullivan, Wiegand 1998 (rate-distortion optimised quantisation).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from math import log2
from typing import Protocol

from conf.errors import ProtocolError
from conf.protocol.codec.range_coder import PRECISION, TOTAL, RangeDecoder, RangeEncoder

MAX_TABLE_MAGNITUDE = 20  # the largest magnitude with a frequency of its own
ESCAPE = 2 * MAX_TABLE_MAGNITUDE + 1  # the symbol for everything larger
SCALES_PER_OCTAVE = 4
MAX_BITS = 13  # of any magnitude: beyond it a payload is garbage
LIMIT = (1 << MAX_BITS) - 1

Cumulative = Sequence[int]


@dataclass(frozen=True)
class Tables:
    """Cumulative frequencies of -REACH..REACH and the escape for each scale, and what each number costs in bits."""

    cumulative: list[list[int]]
    cost: list[list[float]]

    @classmethod
    def from_frequencies(cls, frequencies: Sequence[Sequence[int]]) -> "Tables":
        """Add up the frequencies of each scale. Raises ValueError unless each is positive and they sum to TOTAL."""
        cumulative = [_accumulate(row) for row in frequencies]
        cost = [[PRECISION - log2(f) for f in row] for row in frequencies]
        return cls(cumulative, cost)

    @property
    def last(self) -> int:
        """The largest scale with a table."""
        return len(self.cumulative) - 1


def _accumulate(row: Sequence[int]) -> list[int]:
    total, cumulative = 0, [0]
    for frequency in row:
        if frequency <= 0:
            raise ValueError("a frequency is not positive")
        total += frequency
        cumulative.append(total)
    if total != TOTAL:
        raise ValueError(f"frequencies sum to {total}, not {TOTAL}")
    return cumulative


@cache
def uniform_table(count: int) -> list[int]:
    """Return the table of `count` symbols that are equally likely, as nearly as whole numbers can say it."""
    return [TOTAL * i // count for i in range(count + 1)]


def weighted_table(weights: Sequence[float]) -> list[int]:
    """Return the table of symbols with these weights."""
    spare = TOTAL - len(weights)
    total, frequencies = sum(weights), []
    for weight in weights:
        frequencies.append(1 + int(spare * weight / total))
    frequencies[0] += TOTAL - sum(frequencies)
    return _accumulate(frequencies)


_BITS = [uniform_table(1 << count) for count in range(9)]


class SymbolCoder(Protocol):
    """What the syntax needs: a Writer gives back what it wrote, a Reader ignores what is wanted."""

    def symbol(self, cumulative: Cumulative, value: int) -> int:
        """Code one symbol of a table."""
        ...

    def number(self, tables: Tables, scale: int, target: float) -> int:
        """Code a whole number near `wanted`, in steps, whose usual distance from zero is `scale`."""
        ...


class SymbolWriter:
    """Turn symbols into bytes."""

    def __init__(self, *, rd_lambda: float) -> None:
        self._trade = rd_lambda
        self._range = RangeEncoder()
        self.bits = 0.0  # spent so far, by the tables

    def symbol(self, cumulative: Cumulative, value: int) -> int:
        """Write one symbol."""
        self.bits += PRECISION - log2(cumulative[value + 1] - cumulative[value])
        self._range.write(cumulative, value)
        return value

    def number(self, tables: Tables, scale: int, target: float) -> int:
        """Write the number near `wanted` that is the best bargain of precision and bits."""
        value = max(-LIMIT, min(LIMIT, round(target)))
        if value and scale <= tables.last and -MAX_TABLE_MAGNITUDE <= value <= MAX_TABLE_MAGNITUDE:
            value = self._rate_distortion_choice(tables.cost[scale], target, value)
        self._write(tables, scale, value)
        return value

    def finish(self) -> bytes:
        """Return the payload."""
        return self._range.finish()

    def _rate_distortion_choice(self, cost: list[float], target: float, near: int) -> int:
        less = near - 1 if near > 0 else near + 1
        extra_error = (target - less) ** 2 - (target - near) ** 2
        saved_bits = cost[near + MAX_TABLE_MAGNITUDE] - cost[less + MAX_TABLE_MAGNITUDE]
        return less if extra_error < self._trade * saved_bits else near

    def _write(self, tables: Tables, scale: int, value: int) -> None:
        if scale > tables.last:
            self._large(tables, scale, value)
        elif -MAX_TABLE_MAGNITUDE <= value <= MAX_TABLE_MAGNITUDE:
            self.bits += tables.cost[scale][value + MAX_TABLE_MAGNITUDE]
            self._range.write(tables.cumulative[scale], value + MAX_TABLE_MAGNITUDE)
        else:
            self._escape(tables.cumulative[scale], value)

    def _escape(self, cumulative: Cumulative, value: int) -> None:
        beyond = abs(value) - MAX_TABLE_MAGNITUDE  # 1 or more
        length = beyond.bit_length()
        self.symbol(cumulative, ESCAPE)
        self.symbol(_BITS[4], length)
        self.symbol(_BITS[1], int(value < 0))
        _code_bits(self, length - 1, beyond)

    def _large(self, tables: Tables, scale: int, value: int) -> None:
        scale, shift = _split(scale, tables.last)
        shifted = value + (1 << shift >> 1)
        self._write(tables, scale, shifted >> shift)
        _code_bits(self, shift, shifted)


class SymbolReader:
    """Turn bytes back into symbols. Every method may raise ProtocolError."""

    def __init__(self, data: bytes) -> None:
        self._range = RangeDecoder(data)

    def symbol(self, cumulative: Cumulative, value: int = 0) -> int:
        """Read one symbol."""
        return self._range.read(cumulative)

    def number(self, tables: Tables, scale: int, target: float = 0.0) -> int:
        """Read a number."""
        last = tables.last
        if scale <= last:
            symbol = self._range.read(tables.cumulative[scale])
            return symbol - MAX_TABLE_MAGNITUDE if symbol != ESCAPE else self._escape()
        scale, shift = _split(scale, last)
        high = self.number(tables, scale)
        return (high << shift | _code_bits(self, shift, 0)) - (1 << shift >> 1)

    def finish(self) -> None:
        """Check that nothing is left over or missing."""
        self._range.finish()

    def _escape(self) -> int:
        length = self.symbol(_BITS[4])
        if not 0 < length <= MAX_BITS:
            raise ProtocolError("escape of an impossible length")
        negative = self.symbol(_BITS[1])
        beyond = 1 << length - 1 | _code_bits(self, length - 1, 0)
        return -(MAX_TABLE_MAGNITUDE + beyond) if negative else MAX_TABLE_MAGNITUDE + beyond


def _code_bits(coder: SymbolCoder, count: int, value: int) -> int:
    """Code the lowest `count` bits of `value` as they are, a byte at a time."""
    read = 0
    while count:
        part = min(count, 8)
        count -= part
        read = read << part | coder.symbol(_BITS[part], value >> count & (1 << part) - 1)
    return read


def _split(scale: int, last: int) -> tuple[int, int]:
    """Return a scale that has a table and by how many bits the number is shifted to fit it."""
    shift = -(-(scale - last) // SCALES_PER_OCTAVE)
    return scale - shift * SCALES_PER_OCTAVE, shift
