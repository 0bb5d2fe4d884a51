"""A thread that uses one device until it is closed, and tries again after a failure."""

import threading
from collections.abc import Callable

from conf.errors import ConfError

RETRY_S = 2.0  # after a failure: a device that is plugged in is found soon
CLOSE_S = 3.0  # to wait for a library that is opening a device


class DeviceThread:
    """Calls `use` in a thread, again and again if it fails.

    error : what to tell the user while the device cannot be used; "" while it can, or is being opened
    """

    def __init__(self, use: Callable[["DeviceThread"], None], *, name: str, retry: bool = True) -> None:
        """Start the thread.

        use : opens the device, uses it until `wait` returns True, and closes it
        retry : whether to try again after a ConfError
        """
        self.error = ""
        self._use = use
        self._retry = retry
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)
        self._thread.start()

    @property
    def is_running(self) -> bool:
        """Return whether the thread has not ended."""
        return self._thread.is_alive()

    def wait(self, seconds: float, /) -> bool:
        """Wait in the thread. Returns True, at once, when the thread is to end."""
        return self._closing.wait(seconds)

    def close(self) -> bool:
        """End the thread; wait until the device is released. Returns False if its library does not return."""
        self._closing.set()
        self._thread.join(CLOSE_S)
        return not self._thread.is_alive()

    def begin_close(self) -> None:
        """Tell the thread to end, without waiting: `close` waits. Several devices are released at the same time."""
        self._closing.set()

    def _run(self) -> None:
        while not self._closing.is_set():
            try:
                self._use(self)
            except ConfError as error:
                self.error = str(error)
            if not self._retry or not self.error:
                return
            self.wait(RETRY_S)
