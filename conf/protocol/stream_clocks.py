"""The clocks of a stream: capture times to stream times, and which stream time is due at the other end now.

Stream times are seconds since the capture of a session's first frame or voice. Motion and voice share all clocks, so
that lips and sound agree.

Strategy of the playout clock. Everything received carries its capture time on the sender's clock. The smallest
`arrival - capture time` of the last seconds is the offset between the clocks plus the shortest network delay; what
arrives needs beyond it is its lateness. Content is due at `capture time + offset + delay`. The delay follows the
lateness that all but 2 % of the recent arrivals keep, plus a margin, and of motion and voice the greater. When it
changes, sound is stretched until it is where the clock is; motion stays in step with the sound meanwhile.
Source: playout by deadline as in Ramjee, Kurose, Towsley, Schulzrinne 1994.
"""

from collections import deque
from enum import Enum

import numpy as np

MAX_DELAY_S = 0.5  # beyond the duration of a voice packet
MARGIN_S = 0.010  # scheduling on the receiver's own machine
MAX_LATE_FRACTION = 0.02  # of the arrivals that may be after their deadline
OFFSET_WINDOW_S = 10.0  # long enough to contain an undelayed arrival, short enough to follow the drift of the clocks
DELAY_DECAY = (
    0.02  # per arrival; the delay grows at once, as one that varies is more visible than one slightly too long
)
MAX_STRETCH = 0.1  # of sound whose delay changes: speech stays natural
CLOCK_RESET_S = 30.0  # a timestamp this far from the expected one means that the sender's clock has started again


class StreamClock:
    """The sender's side: capture times to stream times."""

    def __init__(self) -> None:
        self._origin: float | None = None

    def restart(self) -> None:
        """Begin a new session: the next capture time is its stream time 0."""
        self._origin = None

    def offset(self, timestamp: float) -> float:
        """Return the stream time of a capture time, below 0 if it was captured before the first; the first sets 0."""
        self._origin = timestamp if self._origin is None else self._origin
        return timestamp - self._origin

    def stream_time(self, timestamp: float) -> float:
        """The same, at least 0."""
        return max(self.offset(timestamp), 0.0)


class PeerStreamClock:
    """The receiver's side: about which stream time the sender has reached, from the newest that it has named."""

    def __init__(self) -> None:
        self._newest: tuple[float, float] | None = None  # stream time, and ours when it arrived

    def set(self, stream_time: float, now: float) -> None:
        """Apply a stream time at which a body was sent."""
        self._newest = (stream_time, now)

    def advance(self, stream_time: float, now: float) -> None:
        """Apply the stream time of content; older content does not set the clock back."""
        self._newest = max(self._newest or (stream_time, now), (stream_time, now))

    def time(self, now: float) -> float | None:
        """Return the stream time at `now`, None before any has arrived."""
        return None if self._newest is None else self._newest[0] + now - self._newest[1]


class Medium(Enum):
    """What arrives: each has its own lateness."""

    MOTION = "motion"
    VOICE = "voice"


class PlayoutClock:
    """Turn arrivals into the stream time to play out.

    delay_s : added to the shortest way from capture to arrival
    extra_delay_s : more of it, for the latency of the sound output, set by whoever plays the voice
    packet_s : duration of the voice in a packet, for which the delay may be longer
    restarts : how often the sender's clock has started again: what is stored of it has become meaningless
    """

    def __init__(self) -> None:
        self.delay_s = 0.0
        self.extra_delay_s = 0.0
        self.packet_s = 0.0
        self.restarts = 0
        self._transits: dict[Medium, deque[tuple[float, float]]] = {}  # (arrival, arrival - timestamp)
        self._offset: float | None = None
        self._sound_late = (0.0, 0.0)  # by how much, s, and when

    @property
    def has_started(self) -> bool:
        """Whether anything has arrived."""
        return self._offset is not None

    def on_arrival(self, timestamp: float, now: float, *, medium: Medium = Medium.MOTION) -> None:
        """Adapt the delay to content that arrives at `now`. timestamp : capture time of the oldest of it"""
        if self._offset is not None and abs(now - timestamp - self._offset) > CLOCK_RESET_S:
            self._transits.clear()
            self.restarts += 1
        self._transits.setdefault(medium, deque()).append((now, now - timestamp))
        for transits in self._transits.values():
            while transits and transits[0][0] < now - OFFSET_WINDOW_S:
                transits.popleft()
        sorted_transits = [sorted(t for _, t in transits) for transits in self._transits.values() if transits]
        offset = min(transits[0] for transits in sorted_transits)
        quantile = 1 - MAX_LATE_FRACTION
        lateness = max(transits[int(quantile * (len(transits) - 1))] - offset for transits in sorted_transits)
        change = min(lateness + MARGIN_S, MAX_DELAY_S + self.packet_s) - self.delay_s
        self.delay_s += change if change > 0 else change * DELAY_DECAY
        self._offset = offset

    def playhead(self, now: float) -> float:
        """Return the stream time that is due at `now`; it steps back when the delay grows."""
        return now - (self._offset or 0.0) - self.delay_s - self.extra_delay_s

    def follow_sound(self, late_s: float, now: float) -> None:
        """Let motion be as late as the sound that is heard at `now`, against the playhead; negative if it is early."""
        self._sound_late = (late_s, now)

    def motion_playhead(self, now: float) -> float:
        """Return the stream time of the motion that is due at `now`: as soon as sound is where it should be, the same.

        If nobody reports of the sound any more, it is taken to get there at MAX_STRETCH.
        """
        late_s, at = self._sound_late
        left = max(abs(late_s) - MAX_STRETCH * max(now - at, 0.0), 0.0)
        return self.playhead(now) - float(np.copysign(left, late_s))
