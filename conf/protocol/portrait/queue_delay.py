"""The delay that bulk data adds to the motion in the queue of a slow link."""


class QueueDelayModel:
    """Model the queue of a link of `rate` bytes a second twice: with all traffic, and with the motion alone.

    The difference is what the other traffic adds, whatever the amount of motion.
    Source: Lindley 1952 (the wait in a queue from one arrival to the next).
    """

    def __init__(self, rate: float) -> None:
        self._rate = rate
        self._all = self._motion = 0.0  # bytes in the queue
        self._updated_at: float | None = None

    def added_delay(self, size: int, now: float) -> float:
        """Return the seconds that motion sent now would wait for other traffic if `size` more bytes of it were sent."""
        self._drain(now)
        return (self._all - self._motion + size) / self._rate

    def add(self, size: int, now: float) -> None:
        """Count bytes sent that are not motion."""
        self._drain(now)
        self._all += size

    def add_motion(self, size: int, now: float) -> None:
        """Count bytes of motion sent."""
        self._drain(now)
        self._all += size
        self._motion += size

    def _drain(self, now: float) -> None:
        drained = 0.0 if self._updated_at is None else max(0.0, now - self._updated_at) * self._rate
        self._all, self._motion = max(0.0, self._all - drained), max(0.0, self._motion - drained)
        self._updated_at = now
