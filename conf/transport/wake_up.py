"""Wake a thread that waits in `select`, from another thread."""

import socket
import threading


class WakeUp:
    """A flag that `select` can wait for. Any thread may set it; sockets, because Windows can wait for nothing else."""

    def __init__(self) -> None:
        self._reader, self._writer = socket.socketpair()
        self._lock = threading.Lock()
        self._is_set = False

    def fileno(self) -> int:
        """Return the descriptor that is readable while the flag is set."""
        return self._reader.fileno()

    def set(self) -> None:
        """Set the flag; nothing if it is set or closed."""
        with self._lock:
            if not self._is_set and self._writer.fileno() >= 0:
                self._is_set = True
                self._writer.send(b"\0")  # one byte at most waits, so this cannot block

    def clear(self) -> None:
        """Clear the flag."""
        with self._lock:
            if self._is_set and self._reader.fileno() >= 0:
                self._reader.recv(1)
            self._is_set = False

    def close(self) -> None:
        """Free the sockets."""
        with self._lock:
            self._reader.close()
            self._writer.close()
