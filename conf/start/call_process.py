"""A call that runs as a process of its own, so that devices and graphics are released when it ends, however it ends.

Its messages come line by line on its standard error; at the end its figures are one JSON object on standard output.
"""

import json
import subprocess
import threading
from collections import deque
from typing import IO, Any

MAX_LINES = 200  # that are kept
END_S = 5.0  # to end a call in order, before it is killed
_PREFIX = "conf: "


class CallProcess:
    """A running `conf` whose output is read in threads."""

    def __init__(self, process: subprocess.Popen[str]) -> None:
        """process : started with pipes for standard output and standard error"""
        self._process = process
        self._lines: deque[str] = deque(maxlen=MAX_LINES)
        self._unread: deque[str] = deque(maxlen=MAX_LINES)
        self._output = ""
        self._ended_by_user = False
        self._readers = [
            threading.Thread(target=self._read_lines, args=(process.stderr,), daemon=True),
            threading.Thread(target=self._read_output, args=(process.stdout,), daemon=True),
        ]
        for reader in self._readers:
            reader.start()

    @property
    def is_running(self) -> bool:
        """Return whether the process, or what it printed last, is still to come."""
        return self._process.poll() is None or any(reader.is_alive() for reader in self._readers)

    def read_messages(self) -> list[str]:
        """Return the messages since the last call."""
        messages = []
        while self._unread:
            messages.append(self._unread.popleft())
        return messages

    def figures(self) -> dict[str, Any]:
        """Return the figures that a call that has ended printed; none if it printed none."""
        try:
            figures = json.loads(self._output)
        except ValueError:
            return {}
        return figures if isinstance(figures, dict) else {}

    def hang_up(self) -> None:
        """End the call in order: the other side is told, recordings are completed."""
        self._ended_by_user = True
        if self._process.poll() is None:
            self._process.terminate()

    def close(self) -> None:
        """Hang up and wait for the end; kill a process that does not end."""
        self.hang_up()
        try:
            self._process.wait(END_S)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        for reader in self._readers:
            reader.join(END_S)

    def end_text(self) -> str:
        """Return why a process that has ended did, one sentence; "" if it ended as the user wanted."""
        code = self._process.returncode
        if code == 0 or self._ended_by_user:
            return ""
        errors = [line.removeprefix(_PREFIX) for line in self._lines if line.startswith(_PREFIX)]
        if code > 0 and errors:
            return errors[-1]
        reason = f"signal {-code}" if code < 0 else f"exit status {code}"
        last = f": {self._lines[-1]}" if self._lines else ""
        return f"the program of the call stopped ({reason}){last}; `conf doctor` says what works on this machine"

    def _read_lines(self, stream: IO[str]) -> None:
        with stream:
            for line in stream:
                if text := line.strip():
                    self._lines.append(text)
                    self._unread.append(text)

    def _read_output(self, stream: IO[str]) -> None:
        with stream:
            self._output = stream.read()
