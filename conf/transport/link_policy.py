"""When to open the session with a relay again. Sans-IO.

Strategy. A link that has gone means that the relay has restarted or the network has changed: the other link may be as
dead, which a lengthened lease would show after half a minute only, so a new session is opened at once. Without UDP all
goes over TCP, with longer delays: UDP is tried again from time to time.
A NAT or firewall that stops UDP in the middle closes no link. It shows in that nothing is answered any more; then a new
session, which may have TCP alone, finds out. What stops only what is sent shows at the other end, which says so.
"""

from collections.abc import Set

# After failures; the last goes on. A short attempt repeats sooner what was lost. Over TCP a round trip of .6 s, as of a
# satellite, needs 1.8, and one of 1.6 s needs 4.8.
OPEN_TIMEOUTS_S = (1.2, 1.2, 2.5, 5.0)
RETRY_S = (0.1, 0.2, 0.4, 0.8)  # after failures; the last goes on
UDP_RETRY_S = (5.0, 15.0, 45.0, 120.0)  # with TCP alone
SILENT_S = 1.5
UNHEARD_S = 1.0  # for which it counts that the other end hears nothing
SILENT_DATAGRAMS = 4  # sent without an answer: a call sends two reports a second at least
SILENCE_RETRY_S = (5.0, 10.0, 20.0, 40.0, 60.0)  # the other end may just not be there


class LinkPolicy:
    """Decide when to open a session. The kinds of links are "udp" and "tcp"."""

    def __init__(self) -> None:
        self._opened: Set[str] = frozenset()
        self._failures = 0
        self._slowness = 0  # index of the timeout that the last session has needed
        self._tcp_only = 0  # sessions in a row that had no UDP
        self._due = float("-inf")

    @property
    def open_timeout_s(self) -> float:
        """How long the next attempt may take for each link."""
        return OPEN_TIMEOUTS_S[self._next_timeout]

    @property
    def _next_timeout(self) -> int:
        return min(max(self._failures, self._slowness), len(OPEN_TIMEOUTS_S) - 1)

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
        self._slowness = self._next_timeout
        self._opened, self._failures = frozenset(kinds), 0
        self._tcp_only = 0 if "udp" in kinds else self._tcp_only + 1
        if self._tcp_only:
            self._due = now + UDP_RETRY_S[min(self._tcp_only, len(UDP_RETRY_S)) - 1]

    def on_failed(self, now: float) -> None:
        """Note that no session could be opened."""
        self._failures += 1
        self._due = now + RETRY_S[min(self._failures, len(RETRY_S)) - 1]


class SilenceDetector:
    """Notice that nothing comes back, or that nothing arrives.

    `on_received` may be called in another thread. It writes a time that nothing else writes, so that no answer is lost
    while a datagram is being counted.
    """

    def __init__(self) -> None:
        self._unanswered = self._tries = 0
        self._since = 0.0
        self._received_at = self._unheard_at = self._due = float("-inf")

    def on_unheard(self, now: float) -> None:
        """Note that the other end is known to hear nothing."""
        self._unheard_at = now

    def on_sent(self, now: float) -> None:
        """Note a datagram sent."""
        if not self._unanswered or self._received_at >= self._since:
            self._since, self._unanswered = now, 0
        self._unanswered += 1

    def on_received(self, now: float) -> None:
        """Note a datagram received."""
        self._received_at = now

    def is_silent(self, now: float) -> bool:
        """Return whether a new session should find out what is wrong."""
        is_answered = self._received_at >= self._since
        is_silent = self._unanswered >= SILENT_DATAGRAMS and now >= self._since + SILENT_S and not is_answered
        return now >= self._due and (is_silent or now < self._unheard_at + UNHEARD_S)

    def on_opened(self, now: float) -> None:
        """Note a new session, whatever the reason."""
        if self._received_at > self._due:  # since the last attempt
            self._tries = 0
        if self.is_silent(now):
            self._due = now + SILENCE_RETRY_S[min(self._tries, len(SILENCE_RETRY_S) - 1)]
            self._tries += 1
        self._unanswered, self._unheard_at = 0, float("-inf")
