"""How long motion waits because of what is sent beside it."""


class QueueDelayModel:
    """Follows what waits before a link of `rate` bytes a second, twice: with all that was sent, and with motion alone.

    The difference is what the rest costs the motion, however much motion there is. Source: Lindley 1952 (the wait in a
    queue from one arrival to the next).
    """

    def __init__(self, rate: float) -> None:
        self._rate = rate
        self._all = self._motion = 0.0  # bytes that wait
        self._at: float | None = None

    def added_delay(self, size: int, now: float) -> float:
        """Return the seconds that motion sent now would wait for the rest if `size` bytes of it were added."""
        self._drain(now)
        return (self._all - self._motion + size) / self._rate

    def add(self, size: int, now: float) -> None:
        """Note that bytes were sent that are no motion."""
        self._drain(now)
        self._all += size

    def add_motion(self, size: int, now: float) -> None:
        """Note that motion was sent."""
        self._drain(now)
        self._all += size
        self._motion += size

    def _drain(self, now: float) -> None:
        gone = 0.0 if self._at is None else max(0.0, now - self._at) * self._rate
        self._all, self._motion = max(0.0, self._all - gone), max(0.0, self._motion - gone)
        self._at = now
