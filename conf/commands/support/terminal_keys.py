"""Keys that are typed into the terminal while a command runs."""

import os
import select
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

MAX_READ = 64  # bytes


@contextmanager
def terminal_keys() -> Iterator[Callable[[], str] | None]:
    """Yield a function that returns the keys typed since its last call, without waiting; None without a terminal.

    Meanwhile keys are not printed and need no Enter; Ctrl-C interrupts as ever. A command in the background, which
    would be stopped if it read from its terminal, has no keys.
    """
    if sys.platform == "win32":
        import msvcrt

        yield (lambda: "".join(msvcrt.getwch() for _ in range(MAX_READ) if msvcrt.kbhit())) if _is_terminal() else None
        return
    if not _is_terminal() or not _is_in_foreground(fd := sys.stdin.fileno()):
        yield None
        return
    import termios
    import tty

    settings = termios.tcgetattr(fd)
    tty.setcbreak(fd)
    try:
        yield lambda: _read(fd) if _is_in_foreground(fd) else ""
    finally:
        termios.tcsetattr(fd, termios.TCSADRAIN, settings)


def _is_terminal() -> bool:
    return sys.stdin is not None and sys.stdin.isatty()


def _is_in_foreground(fd: int) -> bool:
    if sys.platform == "win32":
        return True
    try:
        return os.tcgetpgrp(fd) == os.getpgrp()
    except OSError:  # not this process's terminal, or it is gone
        return False


def _read(fd: int) -> str:
    if not select.select([fd], [], [], 0)[0]:
        return ""
    try:
        return os.read(fd, MAX_READ).decode(errors="ignore")
    except OSError:  # the terminal is gone
        return ""
