"""A thread that runs until it is stopped, and waits without delaying its end."""

import threading
import time
from collections.abc import Callable

MAX_SLEEP_S = 0.03  # a wait up to this is slept through: waiting for an event takes twice the CPU time


class StoppableThread:
    """Runs a function in a daemon thread. The function ends soon after `is_stopped` is True."""

    def __init__(self, run: Callable[[], None], *, name: str) -> None:
        """run : calls `wait` wherever it has nothing to do"""
        self.is_stopped = False
        self._stopped = threading.Event()
        self._thread = threading.Thread(target=run, name=name, daemon=True)

    def start(self) -> None:
        """Start the thread."""
        self._thread.start()

    def stop(self, max_s: float | None = None) -> None:
        """Stop the thread, if it was started, and wait until it has ended, at most `max_s`."""
        self.is_stopped = True
        self._stopped.set()
        if self._thread.ident is not None:
            self._thread.join(max_s)

    def wait(self, seconds: float) -> bool:
        """Wait, at most until the thread is stopped. Returns whether it is. Called by the thread itself."""
        if seconds > MAX_SLEEP_S:
            return self._stopped.wait(seconds)
        if not self.is_stopped:
            time.sleep(max(seconds, 0.0))
        return self.is_stopped
