"""Decide which frames of a source are sent, and when: a clip at its own speed, a fast camera at a reduced rate."""

MAX_LAG_S = 0.25  # a clip's frame later than this is dropped, so that the call keeps up with the clock


class FramePacer:
    """Selects about `fps` frames a second, each at its time."""

    def __init__(self, fps: float) -> None:
        self.fps = fps  # may be changed between frames
        self._offset: float | None = None  # our clock minus the source's
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
            self._due = timestamp
        source_interval = timestamp - self._previous if self._previous is not None else 0.0
        self._previous = timestamp
        if timestamp < self._due - source_interval / 2:
            return None
        delay = timestamp + self._offset - now
        if delay < -MAX_LAG_S:
            return None
        interval = 1 / self.fps
        # The frames after a gap in the source are not sent in a burst.
        self._due = max(self._due + interval, timestamp + interval / 2)
        return max(delay, 0.0)
