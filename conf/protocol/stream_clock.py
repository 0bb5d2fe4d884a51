"""The stream clock: seconds since the capture of a session's first frame or voice, the same for motion and voice."""


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
