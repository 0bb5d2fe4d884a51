"""Rate limits: a token bucket, and a limit in kbit/s over ten seconds made of one. Time is an argument."""

LIMIT_PERIOD_S = 10.0
BURST_FRACTION = 1 / 16
MIN_BURST_BYTES = 96  # a handshake must pass under any limit


class TokenBucket:
    """Allow `rate` units a second, and `capacity` at once after a pause: in any T seconds rate T + capacity."""

    def __init__(self, rate: float, capacity: float) -> None:
        self.rate = rate
        self.capacity = capacity
        self._tokens = capacity
        self._filled_at: float | None = None

    def take(self, amount: float, now: float) -> bool:
        """Remove `amount` and return True if the bucket holds it; otherwise change nothing and return False."""
        self._fill(now)
        if amount > self._tokens:
            return False
        self._tokens -= amount
        return True

    def force_take(self, amount: float, now: float) -> None:
        """Remove `amount` even if the bucket holds less; the debt never exceeds the capacity."""
        self._fill(now)
        self._tokens = max(self._tokens - amount, -self.capacity)

    def time_until(self, amount: float, now: float) -> float:
        """Return the seconds until the bucket holds `amount`; infinite if it never will."""
        self._fill(now)
        if amount > self.capacity or not self.rate:
            return float("inf") if amount > self._tokens else 0.0
        return max(0.0, (amount - self._tokens) / self.rate)

    def _fill(self, now: float) -> None:
        elapsed = 0.0 if self._filled_at is None else max(0.0, now - self._filled_at)
        self._tokens = min(self.capacity, self._tokens + elapsed * self.rate)
        self._filled_at = now


class RateLimiter:
    """Limit the traffic to `kbps` kbit/s over any ten seconds.

    In any 10 s a bucket passes 10 s of its rate plus its capacity: the two together are the limit.
    max_bytes : size of the largest datagram, headers included, that can ever pass
    """

    def __init__(self, kbps: float) -> None:
        if not kbps > 0:
            raise ValueError("kbps must be above 0")
        allowed = kbps * 1000 / 8 * LIMIT_PERIOD_S
        self.max_bytes = min(max(allowed * BURST_FRACTION, MIN_BURST_BYTES), allowed)
        self._bucket = TokenBucket((allowed - self.max_bytes) / LIMIT_PERIOD_S, self.max_bytes)

    def take(self, wire_bytes: int, now: float) -> bool:
        """Return whether a datagram of `wire_bytes`, headers included, may be sent now, and count it if so."""
        return self._bucket.take(wire_bytes, now)

    def has_headroom(self, wire_bytes: int, now: float) -> bool:
        """Return whether `wire_bytes` could be sent now and leave half of the burst."""
        return self._bucket.time_until(wire_bytes + self.max_bytes / 2, now) == 0
