"""A token bucket: what bounds a rate without a clock of its own."""


class TokenBucket:
    """Let through `rate` units a second, and `capacity` at once after a rest. In any T seconds: rate T + capacity."""

    def __init__(self, rate: float, capacity: float) -> None:
        self.rate = rate
        self.capacity = capacity
        self._tokens = capacity
        self._filled_at: float | None = None

    def take(self, amount: float, now: float) -> bool:
        """Take `amount` if it is there; otherwise change nothing and return False."""
        self._fill(now)
        if amount > self._tokens:
            return False
        self._tokens -= amount
        return True

    def force_take(self, amount: float, now: float) -> None:
        """Take `amount` whether it is there or not; a debt is never larger than the capacity."""
        self._fill(now)
        self._tokens = max(self._tokens - amount, -self.capacity)

    def time_until(self, amount: float, now: float) -> float:
        """Return the seconds until `amount` is there; infinite if it never will be."""
        self._fill(now)
        if amount > self.capacity or not self.rate:
            return float("inf") if amount > self._tokens else 0.0
        return max(0.0, (amount - self._tokens) / self.rate)

    def _fill(self, now: float) -> None:
        elapsed = 0.0 if self._filled_at is None else max(0.0, now - self._filled_at)
        self._tokens = min(self.capacity, self._tokens + elapsed * self.rate)
        self._filled_at = now
