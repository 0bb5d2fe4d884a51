"""How good the link of a call is, in one word, with the reason. Time is an argument."""

from collections import deque
from dataclasses import dataclass
from enum import Enum

from conf.protocol.receive_leg import ReceiveLeg
from conf.protocol.send_leg import LinkStatus

SILENCE_S = 3.0  # three keep-alives
MAX_LOSS_PERCENT = 5.0  # more is heard and seen
MAX_ROUND_TRIP_MS = 400.0  # ITU-T G.114: longer ones hinder a conversation
MAX_JITTER_MS = 300.0  # for which the jitter buffer waits: the link delays datagrams very unevenly
WINDOW_S = 5.0  # over which the loss of what is received is measured
MIN_DATAGRAMS = 20  # in the window
HOLD_S = 3.0  # for which a weak link is shown at least
# The motion profiles by rate; a lower one than at the start means that the link carries less than it should.
PROFILES = ("rich", "live", "voice", "narrow", "slow")


class Quality(Enum):
    """GOOD, WEAK : usable; LOST : nothing arrives; NONE : there is no call"""

    NONE = "waiting"
    GOOD = "good"
    WEAK = "weak"
    LOST = "lost"


@dataclass(frozen=True)
class LinkState:
    """The quality and why it is not good, "" if it is."""

    quality: Quality = Quality.NONE
    reason: str = ""

    @property
    def text(self) -> str:
        """The state in words."""
        return f"{self.quality.value}: {self.reason}" if self.reason else self.quality.value


class LinkMonitor:
    """Judges the link of one call after another."""

    def __init__(self) -> None:
        self._restart()

    def _restart(self) -> None:
        self._received: deque[tuple[float, int, int]] = deque()  # (time, datagrams, lost) of the window
        self._top = len(PROFILES)  # index of the best profile of this call
        self._weak: tuple[float, LinkState] | None = None

    def update(self, status: LinkStatus, stream: ReceiveLeg | None, now: float) -> LinkState:
        """Return the state of the link.

        status : of what is sent; stream : what is received, None while there is no call
        """
        if stream is None or not status.connected:
            self._restart()
            return LinkState()
        if stream.last_received is not None and now - stream.last_received > SILENCE_S:
            return LinkState(Quality.LOST, f"no reply for {now - stream.last_received:.0f} s")
        if status.stopped:
            return LinkState(Quality.LOST, "nothing arrives there")
        reason = self._reason(status, stream, now)
        if reason:
            self._weak = now, LinkState(Quality.WEAK, reason)
        if self._weak and now - self._weak[0] < HOLD_S:
            return self._weak[1]
        return LinkState(Quality.GOOD)

    def _reason(self, status: LinkStatus, stream: ReceiveLeg, now: float) -> str:
        loss = max(status.loss_percent or 0.0, self._received_loss(stream, now))
        if loss >= MAX_LOSS_PERCENT:
            return f"loss {loss:.0f} %"
        if (status.round_trip_ms or 0.0) >= MAX_ROUND_TRIP_MS:
            return f"delay {status.round_trip_ms:.0f} ms"
        jitter_ms = (stream.clock.delay_s - stream.clock.packet_s) * 1000
        if jitter_ms >= MAX_JITTER_MS:
            return f"uneven delay, {jitter_ms:.0f} ms"
        rank = PROFILES.index(status.profile) if status.profile in PROFILES else 0
        self._top = min(self._top, rank)
        return "the link is slow" if rank > self._top else ""

    def _received_loss(self, stream: ReceiveLeg, now: float) -> float:
        """Return the percentage of the other's datagrams that was lost in the window."""
        self._received.append((now, stream.traffic.count, stream.reception.lost))
        while now - self._received[0][0] > WINDOW_S:
            self._received.popleft()
        _, count, lost = self._received[0]
        arrived, missing = stream.traffic.count - count, max(stream.reception.lost - lost, 0)
        return 100 * missing / (arrived + missing) if arrived + missing >= MIN_DATAGRAMS else 0.0
