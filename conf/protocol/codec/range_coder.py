"""A range coder that ends on a byte boundary with the shortest string of bytes inside the final interval.

Strategy. Both sides narrow the same interval of integers symbol by symbol, in proportion to each symbol's frequency.
Coders for long streams keep a fixed number of bits and flush all of them at the end, which is a third of the cost of a
six-byte payload. Here the lower end of the interval is one unbounded Python integer, so that carries need no special
code; only the width is kept short. At the end the number in the interval with the fewest bytes is chosen, and trailing
zero bytes are dropped, because the datagram gives the length. The reader reads zeros after the end. After the last
symbol it can compute the one string that the writer would have chosen, so a truncated or padded payload is rejected.
Source: Martin 1979 (range encoding); Moffat, Neal, Witten 1998 (termination).
"""

from bisect import bisect_right
from collections.abc import Sequence

from conf.errors import ProtocolError

PRECISION = 15  # the frequencies of a table sum to 1 << PRECISION
TOTAL = 1 << PRECISION
_SHIFT = 16
# A smaller width is extended by _SHIFT bits, so a frequency is rounded by at most 2^-17.
_MIN_WIDTH = 1 << 32


class RangeEncoder:
    """Write symbols, each with a table of cumulative frequencies."""

    def __init__(self) -> None:
        self._low = 0
        self._width = 1 << 32
        self._bits = 32

    def write(self, cumulative: Sequence[int], symbol: int) -> None:
        """Write a symbol. cumulative : sums of the frequencies from 0 to TOTAL, one more than there are symbols."""
        step = self._width >> PRECISION
        start = cumulative[symbol]
        self._low += step * start
        width = step * (cumulative[symbol + 1] - start)
        while width < _MIN_WIDTH:
            width <<= _SHIFT
            self._low <<= _SHIFT
            self._bits += _SHIFT
        self._width = width

    def finish(self) -> bytes:
        """Return the bytes of all symbols written."""
        return _shortest(self._low, self._width, self._bits)


class RangeDecoder:
    """Read the symbols of `data` with the tables that they were written with."""

    def __init__(self, data: bytes) -> None:
        self._data = data
        self._position = 4
        self._offset = int.from_bytes(data[:4].ljust(4, b"\0"), "big")  # of the payload's number from _low
        self._width = 1 << 32
        self._low = 0
        self._bits = 32

    def read(self, cumulative: Sequence[int]) -> int:
        """Read a symbol. Raises ProtocolError if the payload lies outside the table."""
        step = self._width >> PRECISION
        target = self._offset // step
        if target >= TOTAL:
            raise ProtocolError("payload outside its tables")
        symbol = bisect_right(cumulative, target) - 1
        start = cumulative[symbol]
        self._offset -= step * start
        self._low += step * start
        width = step * (cumulative[symbol + 1] - start)
        while width < _MIN_WIDTH:
            width <<= _SHIFT
            self._low <<= _SHIFT
            self._bits += _SHIFT
            self._offset = self._offset << _SHIFT | self._next()
        self._width = width
        return symbol

    def finish(self) -> None:
        """Check that the encoder would write this payload. Raises ProtocolError if not."""
        if self._data != _shortest(self._low, self._width, self._bits):
            raise ProtocolError("payload cut short or padded")

    def _next(self) -> int:
        start = self._position
        self._position = start + 2
        return int.from_bytes(self._data[start : start + 2].ljust(2, b"\0"), "big")


def _shortest(low: int, width: int, bits: int) -> bytes:
    """Return the shortest bytes that, followed by zeros, lie in [low, low + width) as a number of `bits` bits."""
    free = (width - 1).bit_length() // 8 * 8 + 8
    while True:  # no multiple of 2^free may lie in the interval: then try a finer grid
        value = -(-low >> free) << free
        if value < low + width:
            return value.to_bytes(bits // 8, "big").rstrip(b"\0")
        free -= 8
