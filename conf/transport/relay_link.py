"""Keep a session with a relay open, in a thread: opening may take seconds and must delay no frame."""

import queue
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from typing import TYPE_CHECKING

from conf.stoppable_thread import StoppableThread
from conf.transport.link_policy import LinkPolicy, SilenceDetector

if TYPE_CHECKING:
    import zenoh

CHECK_S = 0.2
JOIN_S = 4.0  # longer than a first attempt to open, 2.5 s; later ones, which may take ten, are left behind
MAX_TASKS = 64


class RelayLink:
    """A session that is opened again after each failure.

    kinds : links of the session, "udp" and "tcp"; none while there is no session
    """

    def __init__(
        self,
        open_session: "Callable[[float], zenoh.Session]",
        on_open: "Callable[[zenoh.Session], None]",
        fault_text: str,
        *,
        explain: Callable[[], str] | None = None,
        is_supervised: bool = True,
        silence: SilenceDetector | None = None,
    ) -> None:
        """open_session : takes the timeout of each link, s; may raise zenoh.ZError
        on_open : called in the thread for each session, before it is used

        fault_text : what to tell the user while there is no session
        explain : returns what replaces that text if the first attempt to open fails; may block
        is_supervised : whether links that have gone cause a new session; silence : so does what it detects
        """
        self.kinds: frozenset[str] = frozenset()
        self._open_session = open_session
        self._on_open = on_open
        self._fault_text = fault_text
        self._has_failed = False
        self._explain = explain
        self._is_supervised = is_supervised
        self._silence = silence or SilenceDetector()
        self._session: zenoh.Session | None = None
        self._policy = LinkPolicy()
        self._tasks: queue.Queue[Callable[[zenoh.Session], None] | None] = queue.Queue(MAX_TASKS)
        self._thread = StoppableThread(self._run, name="relay")

    @property
    def fault(self) -> str:
        """What to tell the user while there is no session, "" otherwise or before the first attempt has ended."""
        return self._fault_text if self._has_failed else ""

    def start(self) -> None:
        """Begin to open."""
        self._thread.start()

    def call(self, task: "Callable[[zenoh.Session], None]") -> bool:
        """Let the thread run something that may block. Returns whether it was accepted."""
        try:
            self._tasks.put_nowait(task)
        except queue.Full:
            return False
        return True

    def close(self) -> None:
        """Close the session."""
        with suppress(queue.Full):
            self._tasks.put_nowait(None)
        self._thread.stop(JOIN_S)

    def _run(self) -> None:
        from zenoh import ZError

        while not self._thread.is_stopped:
            self._check()
            with suppress(queue.Empty, ZError):
                task = self._tasks.get(timeout=CHECK_S)
                if task and self._session:
                    task(self._session)
        self._replace(None)

    def _check(self) -> None:
        """Open a session if one is due."""
        from zenoh import ZError

        self.kinds = _kinds(self._session)
        if not self._is_due(time.monotonic()):
            return
        session = None
        try:
            session = self._open_session(self._policy.open_timeout_s)
            if not self._thread.is_stopped:
                self._on_open(session)
        except ZError:  # not opened, or closed again at once
            _close(session)
            if not self._policy.is_whole(self.kinds):  # what is left of the session is as dead
                self._replace(None)
                self.kinds, self._has_failed = frozenset(), True
                self._ask_why()
            self._policy.on_failed(time.monotonic())
            return
        self._replace(session)
        self._has_failed, self._explain, self.kinds = False, None, _kinds(session)
        self._policy.on_opened(self.kinds, time.monotonic())
        self._silence.on_opened(time.monotonic())

    def _ask_why(self) -> None:
        """Find out why the first attempt has failed, in another thread: the next attempt does not wait for that."""
        explain, self._explain = self._explain, None
        if explain:
            threading.Thread(target=self._replace_text, args=(explain,), name="relay-fault", daemon=True).start()

    def _replace_text(self, explain: Callable[[], str]) -> None:
        self._fault_text = explain()

    def _is_due(self, now: float) -> bool:
        """Return whether to open a session now."""
        if self._session and self._silence.is_silent(now):
            return True
        return self._policy.is_due(self.kinds, now) if self._is_supervised else self._session is None

    def _replace(self, session: "zenoh.Session | None") -> None:
        old, self._session = self._session, session
        _close(old)


def _kinds(session: "zenoh.Session | None") -> frozenset[str]:
    from zenoh import ZError

    try:
        return frozenset(link.dst.partition("/")[0] for link in session.info.links()) if session else frozenset()
    except ZError:
        return frozenset()


def _close(session: "zenoh.Session | None") -> None:
    from zenoh import ZError

    if session:
        with suppress(ZError):
            session.close()
