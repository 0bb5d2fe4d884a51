"""Keys typed into a terminal: read without Enter, the terminal is left as it was."""

import os
import sys
from types import SimpleNamespace

import pytest

from conf.commands.support.terminal_keys import terminal_keys

if sys.platform == "win32":
    pytest.skip("needs a pseudo-terminal", allow_module_level=True)

import pty
import termios

LOCAL_FLAGS = 3  # index in what tcgetattr returns


@pytest.fixture
def keyboard(monkeypatch: pytest.MonkeyPatch) -> int:
    """Make standard input a terminal whose keyboard is the file that is returned."""
    keyboard, terminal = pty.openpty()
    monkeypatch.setattr("sys.stdin", os.fdopen(terminal, closefd=False))
    monkeypatch.setattr("os.tcgetpgrp", lambda fd: os.getpgrp())
    return keyboard


def test_keys_come_at_once_and_are_not_printed(keyboard: int) -> None:
    before = termios.tcgetattr(sys.stdin.fileno())
    with terminal_keys() as read:
        assert read is not None and read() == ""
        os.write(keyboard, b"mx")
        assert read() == "mx" and read() == ""
        flags = termios.tcgetattr(sys.stdin.fileno())[LOCAL_FLAGS]
        assert not flags & termios.ECHO and flags & termios.ISIG
    assert termios.tcgetattr(sys.stdin.fileno()) == before


def test_the_terminal_is_restored_after_an_error(keyboard: int) -> None:
    before = termios.tcgetattr(sys.stdin.fileno())
    with pytest.raises(KeyboardInterrupt), terminal_keys():
        raise KeyboardInterrupt
    assert termios.tcgetattr(sys.stdin.fileno()) == before


def test_a_command_in_the_background_reads_nothing(keyboard: int, monkeypatch: pytest.MonkeyPatch) -> None:
    with terminal_keys() as read:
        os.write(keyboard, b"m")
        monkeypatch.setattr("os.tcgetpgrp", lambda fd: os.getpgrp() + 1)
        assert read is not None and read() == ""
        with terminal_keys() as none:
            assert none is None


@pytest.mark.parametrize("stdin", [None, SimpleNamespace(isatty=lambda: False)])
def test_without_a_terminal_there_are_no_keys(stdin: object, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sys.stdin", stdin)
    with terminal_keys() as read:
        assert read is None
