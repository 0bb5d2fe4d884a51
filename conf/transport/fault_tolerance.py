"""Survive failures that pass: a firewall that is reloaded, a cable that is moved."""

from conf.errors import ConfError

NETWORK_LIMIT_S = 10.0
CAMERA_LIMIT_S = 5.0


class FaultTolerance:
    """Accepts one kind of failure for a limited time, once the thing has worked.

    note : what to tell the user while it lasts, "" otherwise
    has_worked : whether the thing has ever worked
    """

    def __init__(self, limit_s: float, *, has_worked: bool = False) -> None:
        """has_worked : the first failure is accepted too"""
        self.note = ""
        self._limit_s = limit_s
        self.has_worked = has_worked
        self._failing_since: float | None = None

    def on_success(self) -> None:
        """Note that it works."""
        self.has_worked, self._failing_since, self.note = True, None, ""

    def on_failure(self, error: ConfError, now: float) -> None:
        """Note a failure. Raises the error if it has never worked, or has failed for the whole limit."""
        if self._failing_since is None:
            self._failing_since = now
        left = self._limit_s - (now - self._failing_since)
        if not self.has_worked or left <= 0:
            raise error
        self.note = f"{error} (trying for {left:.0f} s more)"
