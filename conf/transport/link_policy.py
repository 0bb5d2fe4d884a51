"""When to open the session with a relay again. Sans-IO.

Strategy. A link that has gone means that the relay has restarted or the network has changed: the other link may be as
dead, which a lengthened lease would show after half a minute only, so a new session is opened at once. Without UDP all
goes over TCP, with longer delays: UDP is tried again from time to time.
"""

from collections.abc import Set

RETRY_S = (0.1, 0.2, 0.4, 0.8)  # after failures; the last goes on
UDP_RETRY_S = (5.0, 15.0, 45.0, 120.0)  # with TCP alone


class LinkPolicy:
    """Decide when to open a session. The kinds of links are "udp" and "tcp"."""

    def __init__(self) -> None:
        self._opened: Set[str] = frozenset()
        self._failures = 0
        self._tcp_only = 0  # sessions in a row that had no UDP
        self._due = float("-inf")

    def is_due(self, kinds: Set[str], now: float) -> bool:
        """Return whether to open a session now, in place of one if there is one. kinds : links that there are"""
        is_whole = self.is_whole(kinds)
        if is_whole and "udp" in kinds:
            return False
        return now >= self._due or (not is_whole and not self._failures)

    def is_whole(self, kinds: Set[str]) -> bool:
        """Return whether the session has all links with which it was opened."""
        return bool(kinds) and kinds >= self._opened

    def on_opened(self, kinds: Set[str], now: float) -> None:
        """Note a new session."""
        self._opened, self._failures = frozenset(kinds), 0
        self._tcp_only = 0 if "udp" in kinds else self._tcp_only + 1
        if self._tcp_only:
            self._due = now + UDP_RETRY_S[min(self._tcp_only, len(UDP_RETRY_S)) - 1]

    def on_failed(self, now: float) -> None:
        """Note that no session could be opened."""
        self._failures += 1
        self._due = now + RETRY_S[min(self._failures, len(RETRY_S)) - 1]
