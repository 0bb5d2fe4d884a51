"""Announce the furrows between the brows, in a body of their own beside the motion. No I/O, no clock.

Strategy. A level is sent when it has changed, and again until a report confirms it, so that a brow at rest costs
nothing. Each body holds the whole level: nothing drifts, whatever is lost. What is never confirmed, as by a receiver
that knows no furrows, is repeated ever more rarely.
"""

from collections.abc import Iterable

from conf.protocol.messages import FurrowMessage
from conf.protocol.outgoing import OutgoingBody
from conf.protocol.wire import MAX_FURROW_LEVEL, encode_body

HYSTERESIS = 0.75  # levels from the one sent: a value between two levels does not flicker
MIN_INTERVAL_S = 0.25  # from one level to the next: a frown that grows costs about three bodies
REPEAT_S = 1.0  # until a level is repeated, longer than a report takes; doubles each time
FURROW_BYTES = 3  # of the body, with one for a composite


class FurrowAnnouncer:
    """Turn one sender's furrows into message bodies, in a session whose receiver assumes none at first."""

    def __init__(self) -> None:
        self._level = 0  # sent last
        self._next_at = float("-inf")  # when a change may be sent
        self._repeat_at = float("inf")  # when the level is sent again, never if it has arrived
        self._repeat_s = REPEAT_S
        self._counters: set[int] = set()  # of the datagrams with this level

    def is_due(self, furrow: float, timestamp: float) -> bool:
        """Return whether a frame's furrows, 0 to 1, should be sent. timestamp : of its capture, seconds"""
        has_changed = abs(_levels(furrow) - self._level) >= HYSTERESIS
        return timestamp >= (self._next_at if has_changed else self._repeat_at)

    def body(self, furrow: float, timestamp: float) -> OutgoingBody:
        """Return the body of a frame's furrows, which is sent with it."""
        level = round(_levels(furrow))
        if level == self._level:
            self._repeat_s *= 2
        else:
            self._level, self._repeat_s = level, REPEAT_S
            self._counters.clear()
        self._next_at, self._repeat_at = timestamp + MIN_INTERVAL_S, timestamp + self._repeat_s
        message = FurrowMessage(level)
        return OutgoingBody(encode_body(message), furrow=message)

    def on_sent(self, counter: int, outgoing: OutgoingBody) -> None:
        """Record the counter of the datagram in which a body was sent."""
        if outgoing.furrow == FurrowMessage(self._level):
            self._counters.add(counter)

    def on_acknowledged(self, counters: Iterable[int]) -> None:
        """Apply the counters that the receiver has decoded."""
        if not self._counters.isdisjoint(counters):
            self._counters.clear()
            self._repeat_at = float("inf")


def _levels(furrow: float) -> float:
    return min(max(furrow, 0.0), 1.0) * MAX_FURROW_LEVEL
