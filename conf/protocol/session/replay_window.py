"""The counters received: a window of the newest 64, as in IPsec (RFC 4303, 3.4.3)."""

from conf.protocol.session.drop_reasons import DatagramError, DropReason

WINDOW = 64
_MASK = (1 << WINDOW) - 1


class ReplayWindow:
    """Accept every counter once.

    highest : the highest counter accepted, -1 before the first
    received : bit i is set if counter `highest - i` was accepted
    """

    def __init__(self) -> None:
        self.highest = -1
        self.received = 0

    def check(self, counter: int) -> None:
        """Raise DatagramError if the counter was accepted before or is too old to tell. Changes nothing."""
        behind = self.highest - counter
        if behind >= WINDOW:
            raise DatagramError(DropReason.TOO_OLD)
        if behind >= 0 and self.received >> behind & 1:
            raise DatagramError(DropReason.REPLAYED)

    def accept(self, counter: int) -> None:
        """Record a counter that passed `check` and whose datagram is authentic."""
        ahead = counter - self.highest
        if ahead > 0:
            self.received = ((self.received << min(ahead, WINDOW)) | 1) & _MASK
            self.highest = counter
        else:
            self.received |= 1 << -ahead
