"""The jitter buffer: frames come when the network pleases and are shown when their time has come.

Strategy. Every frame carries the time of its capture on the sender's clock. The smallest `arrival - timestamp` of the
last seconds is the offset between the two clocks plus the shortest way through the network; what a frame needs beyond
it is its lateness. A frame is due at `timestamp + offset + playout delay`, and the playout delay follows the lateness
that all but a few of the recent frames keep to, plus a margin. Nothing is counted: a lost frame is simply not there
when the playhead passes, so one loss never stops playout.

Between two frames the playhead interpolates. Past the newest one it holds, and after HOLD_S eases to the neutral face,
so that a dead link does not freeze a grimace.
Source: playout by deadline as in Ramjee, Kurose, Towsley, Schulzrinne 1994.
"""

from bisect import bisect_right
from collections import deque
from dataclasses import dataclass, replace

import numpy as np

from conf.protocol.messages import MotionFrame

MAX_DELAY_S = 0.5
MARGIN_S = 0.010  # scheduling on the receiver's own machine
LATE_SHARE = 0.02  # how many of the frames may come after their time
OFFSET_WINDOW_S = 10.0  # long enough to hold an undelayed frame, short enough to follow two clocks drifting apart
HOLD_S = 1.5
EASE_S = 1.0
KEPT_S = 2.0  # frames kept behind the playhead
MAX_FRAMES = 256  # whatever a peer sends, memory stays bounded
BLEND_S = 0.25  # a longer gap was a still face: the motion belongs to its end
NEW_CLOCK_S = 30.0  # a capture time this far off its place means that the sender's clock has started anew


@dataclass(frozen=True)
class PlayoutFrame:
    """What to draw now.

    frame : the interpolated motion, its timestamp the playhead on the sender's clock
    stale_s : seconds since the playhead passed the newest frame, 0 while there are frames ahead
    neutral : 0 while the motion is the sender's, up to 1 when it has eased to the neutral face
    """

    frame: MotionFrame
    age_s: float
    neutral_blend: float


class JitterBuffer:
    """Order frames by capture time and play them at their deadline."""

    def __init__(self, *, min_delay_s: float = 0.0) -> None:
        self.min_delay_s = min_delay_s
        self.late = 0
        self.playout_delay_s = min_delay_s
        self._frames: list[MotionFrame] = []  # by timestamp
        self._transits: deque[tuple[float, float]] = deque()  # (arrival, arrival - timestamp)
        self._offset = 0.0
        self._playhead = -np.inf

    def add(self, frame: MotionFrame, now: float) -> None:
        """Put a frame in its place, and learn from its arrival at `now`."""
        if self._frames and abs(now - frame.timestamp - self._offset) > NEW_CLOCK_S:
            self._start_anew()
        self._learn(now, now - frame.timestamp)
        if frame.timestamp <= self._playhead:
            self.late += 1
        at = bisect_right(self._frames, frame.timestamp, key=lambda f: f.timestamp)
        if at and self._frames[at - 1].timestamp == frame.timestamp:
            return
        self._frames.insert(at, frame)
        del self._frames[:-MAX_FRAMES]

    def repeat_until(self, timestamp: float, now: float) -> None:
        """Note that the face has not moved up to `timestamp`: the newest frame is shown on."""
        if self._frames and timestamp > self._frames[-1].timestamp:
            self.add(replace(self._frames[-1], timestamp=timestamp), now)

    def play(self, now: float) -> PlayoutFrame | None:
        """Return what to draw at `now`, or None before the first frame is due."""
        if not self._frames:
            return None
        playhead = now - self._offset - self.playout_delay_s
        self._playhead = max(self._playhead, playhead)
        self._forget(self._playhead - KEPT_S)
        at = bisect_right(self._frames, self._playhead, key=lambda f: f.timestamp)
        if at == 0:
            return None
        if at < len(self._frames):
            return PlayoutFrame(_between(self._frames[at - 1], self._frames[at], self._playhead), 0.0, 0.0)
        stale = self._playhead - self._frames[-1].timestamp
        return _after(self._frames[-1], stale)

    def _learn(self, now: float, transit: float) -> None:
        self._transits.append((now, transit))
        while self._transits[0][0] < now - OFFSET_WINDOW_S:
            self._transits.popleft()
        transits = np.array([t for _, t in self._transits])
        offset = float(transits.min())
        lateness = float(np.quantile(transits - offset, 1 - LATE_SHARE, method="lower"))
        self._offset = offset
        wanted = min(max(lateness + MARGIN_S, self.min_delay_s), MAX_DELAY_S)
        # Up at once, down slowly: a delay that breathes is worse to look at than one that is a little long.
        self.playout_delay_s += (wanted - self.playout_delay_s) * (1.0 if wanted > self.playout_delay_s else 0.02)

    def _forget(self, before: float) -> None:
        while len(self._frames) > 1 and self._frames[1].timestamp < before:
            self._frames.pop(0)

    def _start_anew(self) -> None:
        self._frames.clear()
        self._transits.clear()
        self._playhead = -np.inf


def _between(a: MotionFrame, b: MotionFrame, timestamp: float) -> MotionFrame:
    begin = max(a.timestamp, b.timestamp - BLEND_S)
    share = max(timestamp - begin, 0.0) / (b.timestamp - begin)
    return MotionFrame(
        timestamp,
        a.displacements + np.float32(share) * (b.displacements - a.displacements),
        a.pose + share * (b.pose - a.pose),
    )


def _after(newest: MotionFrame, stale: float) -> PlayoutFrame:
    neutral = float(np.clip((stale - HOLD_S) / EASE_S, 0.0, 1.0))
    eased = neutral * neutral * (3 - 2 * neutral)
    shown = replace(
        newest,
        timestamp=newest.timestamp + stale,
        displacements=newest.displacements * np.float32(1 - eased),
    )
    return PlayoutFrame(shown, stale, eased)
