"""A range coder that ends on a byte: the shortest string of bytes inside the final interval.

Strategy. Both sides narrow the same interval of whole numbers, symbol by symbol, each in proportion to its frequency.
Coders for long streams keep a fixed number of bits and must flush them all at the end, which for a six-byte payload is
a third of the cost. Here the interval's lower end is one unbounded Python integer, so a carry needs no care, only its
width is kept short; at the end the number in the interval with the fewest bytes is taken, and trailing zero bytes are
left out because the datagram tells the length anyway. The reader sees zeros after the end. Having read everything it
can tell the one string the writer would have chosen, so a payload cut short or padded is refused, not misread.
Source: Martin 1979 (range encoding); Moffat, Neal, Witten 1998 (termination).
"""

from bisect import bisect_right
from collections.abc import Sequence

from conf.errors import ProtocolError

PRECISION = 15  # frequencies of a table add up to 1 << PRECISION
TOTAL = 1 << PRECISION
_SHIFT = 16
_LOW_WIDTH = 1 << 32  # a width below this is widened by _SHIFT bits: a frequency is never rounded by more than 2^-17


class RangeEncoder:
    """Write symbols, each given by its table of cumulative frequencies; then `finish`."""

    def __init__(self) -> None:
        self._low = 0
        self._width = 1 << 32
        self._bits = 32

    def write(self, cumulative: Sequence[int], symbol: int) -> None:
        """Write a symbol. cumulative: frequencies added up, from 0 to TOTAL, one more than there are symbols."""
        step = self._width >> PRECISION
        start = cumulative[symbol]
        self._low += step * start
        width = step * (cumulative[symbol + 1] - start)
        while width < _LOW_WIDTH:
            width <<= _SHIFT
            self._low <<= _SHIFT
            self._bits += _SHIFT
        self._width = width

    def finish(self) -> bytes:
        """Return the bytes of everything written."""
        return _shortest(self._low, self._width, self._bits)


class RangeDecoder:
    """Read the symbols of `data` with the tables they were written with; then `finish`."""

    def __init__(self, data: bytes) -> None:
        self._data = data
        self._taken = 4
        self._offset = int.from_bytes(data[:4].ljust(4, b"\0"), "big")  # where the payload lies in the interval
        self._width = 1 << 32
        self._low = 0
        self._bits = 32

    def read(self, cumulative: Sequence[int]) -> int:
        """Read a symbol. Raises ProtocolError when the payload points outside the table."""
        step = self._width >> PRECISION
        share = self._offset // step
        if share >= TOTAL:
            raise ProtocolError("payload outside its tables")
        symbol = bisect_right(cumulative, share) - 1
        start = cumulative[symbol]
        self._offset -= step * start
        self._low += step * start
        width = step * (cumulative[symbol + 1] - start)
        while width < _LOW_WIDTH:
            width <<= _SHIFT
            self._low <<= _SHIFT
            self._bits += _SHIFT
            self._offset = self._offset << _SHIFT | self._next()
        self._width = width
        return symbol

    def finish(self) -> None:
        """Check that the payload is the one the encoder writes. Raises ProtocolError if it is not."""
        if self._data != _shortest(self._low, self._width, self._bits):
            raise ProtocolError("payload cut short or padded")

    def _next(self) -> int:
        at = self._taken
        self._taken = at + 2
        return int.from_bytes(self._data[at : at + 2].ljust(2, b"\0"), "big")


def _shortest(low: int, width: int, bits: int) -> bytes:
    """Return the shortest bytes that, followed by zeros, lie in [low, low + width) as a number of `bits` bits."""
    if not low:
        return b""
    free = (width - 1).bit_length() // 8 * 8 + 8
    while True:  # multiples of 2^free may all miss the interval: then try finer ones
        value = -(-low >> free) << free
        if value < low + width:
            return value.to_bytes(bits // 8, "big").rstrip(b"\0")
        free -= 8
