"""A router that a test plays: what a front carries there arrives here."""

import selectors
import socket
from types import TracebackType
from typing import Self

LOOPBACK = "127.0.0.1"
TIMEOUT_S = 5.0


class FakeRouter:
    """Listens where a front expects the router; use `with`."""

    def __init__(self) -> None:
        self.selector = selectors.DefaultSelector()
        self.now = 0.0
        self._listener = socket.create_server((LOOPBACK, 0))
        self._listener.settimeout(TIMEOUT_S)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._listener.close()
        self.selector.close()

    @property
    def address(self) -> tuple[str, int]:
        """Where it listens."""
        return LOOPBACK, int(self._listener.getsockname()[1])

    def accept(self) -> socket.socket:
        """Return the next connection of the front."""
        handle, _ = self._listener.accept()
        handle.settimeout(TIMEOUT_S)
        return handle

    def carry(self, seconds: float = 0.05) -> None:
        """Let the front do what can be done, until nothing arrives any more."""
        while ready := self.selector.select(seconds):
            for key, mask in ready:
                key.data(mask, self.now)
