"""Rate limits: a token bucket, and a limit in kbit/s over ten seconds. Time is an argument."""

from collections import deque

LIMIT_PERIOD_S = 10.0
BURST_FRACTION = 1 / 16
MAX_EARLY_S = 0.05  # by which a datagram of a steady stream may leave before its time
MIN_BURST_BYTES = 96  # a handshake must pass under any limit


class TokenBucket:
    """Allow `rate` units a second, and `capacity` at once after a pause: in any T seconds rate T + capacity."""

    def __init__(self, rate: float, capacity: float, *, max_debt: float | None = None) -> None:
        """max_debt : units that `force_take` may remove beyond what the bucket holds; the capacity if None"""
        self.rate = rate
        self.capacity = capacity
        self._max_debt = capacity if max_debt is None else max_debt
        self._tokens = capacity
        self._filled_at: float | None = None

    def consume(self, amount: float, now: float) -> bool:
        """Remove `amount` and return True if the bucket holds it; otherwise change nothing and return False."""
        self._fill(now)
        if amount > self._tokens:
            return False
        self._tokens -= amount
        return True

    def force_take(self, amount: float, now: float) -> None:
        """Remove `amount` even if the bucket holds less, down to the maximum debt."""
        self._fill(now)
        self._tokens = max(self._tokens - amount, -self._max_debt)

    def debt(self, now: float) -> float:
        """Return the units that were removed beyond what the bucket held and have not been refilled, at least 0."""
        self._fill(now)
        return max(0.0, -self._tokens)

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

    Bursts pass a token bucket, whose rate and capacity together are the limit. A steady stream may use the limit
    completely: its datagrams need only fit the ten seconds that end with them.
    max_bytes : size of the largest datagram, headers included, that can ever pass the bucket
    """

    def __init__(self, kbps: float) -> None:
        if not kbps > 0:
            raise ValueError("kbps must be above 0")
        self._allowed = kbps * 1000 / 8 * LIMIT_PERIOD_S
        self.max_bytes = min(max(self._allowed * BURST_FRACTION, MIN_BURST_BYTES), self._allowed)
        self._bucket = TokenBucket((self._allowed - self.max_bytes) / LIMIT_PERIOD_S, self.max_bytes)
        self._recent: deque[tuple[float, int]] = deque()  # times and bytes of the last ten seconds
        self._sum = 0

    def consume(self, wire_bytes: int, now: float) -> bool:
        """Return whether a datagram of `wire_bytes`, headers included, may be sent now, and count it if so."""
        if not self._fits(wire_bytes, now) or not self._bucket.consume(wire_bytes, now):
            return False
        self._count(wire_bytes, now)
        return True

    def consume_steady(self, wire_bytes: int, now: float) -> bool:
        """Return the same for a datagram of a steady stream."""
        if not self._fits(wire_bytes, now):
            return False
        self._bucket.force_take(wire_bytes, now)
        self._count(wire_bytes, now)
        return True

    def room(self, stream_bytes: int, interval_s: float, now: float) -> float:
        """Return how large a datagram may be now so that a stream of such datagrams can go on after it.

        stream_bytes, interval_s : of the stream's datagrams, headers included; the first follows in `interval_s`
        """
        self._drop_old(now)
        kept, count = self._sum, 0
        room = self._allowed - kept
        times = iter(self._recent)
        oldest = next(times, None)
        while (count + 1) * interval_s - MAX_EARLY_S < LIMIT_PERIOD_S:
            count += 1
            while oldest and oldest[0] + LIMIT_PERIOD_S <= now + count * interval_s - MAX_EARLY_S:
                kept -= oldest[1]
                oldest = next(times, None)
            room = min(room, self._allowed - kept - count * stream_bytes)
        return room

    def has_headroom(self, wire_bytes: int, now: float) -> bool:
        """Return whether `wire_bytes` could be sent now and leave half of the burst."""
        return self._bucket.time_until(wire_bytes + self.max_bytes / 2, now) == 0

    def _fits(self, wire_bytes: int, now: float) -> bool:
        self._drop_old(now)
        return self._sum + wire_bytes <= self._allowed

    def _count(self, wire_bytes: int, now: float) -> None:
        self._recent.append((now, wire_bytes))
        self._sum += wire_bytes

    def _drop_old(self, now: float) -> None:
        while self._recent and self._recent[0][0] + LIMIT_PERIOD_S <= now:
            self._sum -= self._recent.popleft()[1]
