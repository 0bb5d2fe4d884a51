"""The circuit breaker: no reports, no traffic. Time is an argument. Source: RFC 8083."""

OPEN_AFTER_S = 10.0
FIRST_PROBE_S = 1.0
MAX_PROBE_S = 8.0


class CircuitBreaker:
    """Stop sending 10 s after the last report; allow probes at growing intervals until a report closes it again."""

    def __init__(self, now: float) -> None:
        self._last_report = now
        self._probe_due = now
        self._probe_s = FIRST_PROBE_S

    def on_report(self, now: float) -> None:
        """Close the breaker: a report has arrived."""
        self._last_report = now
        self._probe_s = FIRST_PROBE_S

    def is_open(self, now: float) -> bool:
        """Return whether nothing but probes may be sent."""
        return now >= self._last_report + OPEN_AFTER_S

    def consume_probe(self, now: float) -> bool:
        """Return whether one small datagram (a keep-alive) may be sent although the breaker is open, and count it."""
        if not self.is_open(now) or now < self._probe_due:
            return False
        self._probe_due = now + self._probe_s
        self._probe_s = min(2 * self._probe_s, MAX_PROBE_S)
        return True
