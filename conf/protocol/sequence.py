"""Sequence numbers: unwrapping the few bits that travel, and counting what arrived, twice, late or never.

Source: RFC 3550, Appendix A.1 and A.3, without the wrap-around: counters here are unwrapped to Python integers.
"""


def unwrap(low: int, /, *, bits: int, expected: int) -> int:
    """Return the non-negative integer nearest to `near` whose lowest `bits` bits are `low`."""
    span = 1 << bits
    candidate = expected - (expected - low + span // 2) % span + span // 2
    return candidate if candidate >= 0 else candidate + span


class ReceptionLog:
    """Which sequence numbers have come: duplicates are known for the newest WINDOW numbers."""

    WINDOW = 1024

    def __init__(self) -> None:
        self.first: int | None = None
        self.highest = -1
        self.received = 0
        self.duplicates = 0
        self._seen: set[int] = set()

    @property
    def lost(self) -> int:
        """How many numbers between the first and the highest have not come (yet)."""
        return 0 if self.first is None else self.highest - self.first + 1 - self.received

    def add(self, number: int) -> bool:
        """Note an arrival. Returns False for a duplicate or a number older than the window, which is not counted."""
        if self.first is None:
            self.first = self.highest = number
        if number in self._seen or number <= self.highest - self.WINDOW:
            self.duplicates += 1
            return False
        self.first = min(self.first, number)
        self.received += 1
        self._seen.add(number)
        if number > self.highest:
            self.highest = number
            if len(self._seen) > 2 * self.WINDOW:
                self._seen = {n for n in self._seen if n > number - self.WINDOW}
        return True
