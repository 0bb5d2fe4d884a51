"""Decide which frames of a source are sent, and when: a clip at its own speed, a fast camera at a reduced rate.

Frames go to the receiver with times in ticks, 1/fps apart. Those near a tick of the first frame's are selected, also
after a gap: others would be shown up to half a tick too early or too late, and lips would leave the voice by as much.
"""

import math

TOLERANCE = 1e-6  # of a tick
MAX_LAG_S = 0.25  # a clip's frame later than this is dropped, so that the call keeps up with the clock


class FramePacer:
    """Selects about `fps` frames a second, each at its time."""

    def __init__(self, fps: float) -> None:
        self.fps = fps  # may be changed between frames
        self._offset: float | None = None  # our clock minus the source's
        self._origin = 0.0  # timestamp of the first frame
        self._due = float("-inf")  # timestamp of the next frame to send
        self._previous: float | None = None

    def source_time(self, now: float) -> float | None:
        """Return the time on the source's clock at `now`, None before the first frame."""
        return None if self._offset is None else now - self._offset

    def delay_for(self, timestamp: float, now: float) -> float | None:
        """Return the seconds to wait before this frame is sent, or None if it is to be dropped.

        timestamp : seconds on the source's clock, rising; now : seconds on ours
        """
        if self._offset is None:
            self._offset = now - timestamp
            self._due = self._origin = timestamp
        source_interval = timestamp - self._previous if self._previous is not None else 0.0
        self._previous = timestamp
        if timestamp < self._due - source_interval * (0.5 + TOLERANCE):  # of two as near to a tick the earlier is sent
            return None
        delay = timestamp + self._offset - now
        if delay < -MAX_LAG_S:
            self._due = self._tick_after(timestamp + source_interval / 2)
            return None
        # The frames after a gap in the source are not sent in a burst.
        self._due = max(self._tick_after(self._due + 0.5 / self.fps), self._tick_after(timestamp + 0.5 / self.fps))
        return max(delay, 0.0)

    def _tick_after(self, timestamp: float) -> float:
        """Return the first tick that is not before a timestamp."""
        return self._origin + math.ceil((timestamp - self._origin) * self.fps - TOLERANCE) / self.fps
