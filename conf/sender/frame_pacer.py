"""Which frames of a source are sent, and when: a clip plays at its own speed, a fast camera is thinned out."""

MAX_LAG_S = 0.25  # a clip's frame this old is dropped: the call must not fall behind the clock


class FramePacer:
    """Choose frames so that about `fps` of them a second are sent, each at its time."""

    def __init__(self, fps: float) -> None:
        self.fps = fps  # may be changed between frames
        self._start: float | None = None  # what to add to a timestamp to get the clock
        self._due = float("-inf")  # timestamp of the next frame to send
        self._previous: float | None = None

    def delay_for(self, timestamp: float, now: float) -> float | None:
        """Return how many seconds to wait before this frame is sent, or None when it is not to be sent.

        timestamp : seconds on the source's clock, rising; now : seconds on ours
        """
        if self._start is None:
            self._start = now - timestamp
            self._due = timestamp
        source_interval = timestamp - self._previous if self._previous is not None else 0.0
        self._previous = timestamp
        if timestamp < self._due - source_interval / 2:
            return None
        wait = timestamp + self._start - now
        if wait < -MAX_LAG_S:
            return None
        interval = 1 / self.fps
        # A gap in the source does not make the frames after it come in a rush.
        self._due = max(self._due + interval, timestamp + interval / 2)
        return max(wait, 0.0)
