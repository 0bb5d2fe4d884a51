"""The commands, one module each.

A module has HELP, add_arguments(parser), which adds the command's options, and run(options, terminal), which executes
it, prints through the terminal that cli.py passes in and raises ConfError. `conf --help` imports all of these modules:
to keep it fast they import NumPy, OpenCV and most of conf inside their functions.
"""

from collections.abc import Callable, Iterable
from contextlib import AbstractContextManager
from typing import Any, Protocol


class Terminal(Protocol):
    """Where a command prints. With --json messages go to stderr and progress is hidden.

    ask returns "" if there is no user. status_line and progress_bar yield a function that sets the text, or the
    fraction from 0 to 1. print_figures prints a dataclass as a table, or as the text or rich table given, or as one
    JSON object; print_list a text or rich table about dataclasses, or one JSON object with their list under a key.
    """

    def write(self, text: str, /) -> None: ...
    def ask(self, question: str, /) -> str: ...
    def status_line(self) -> AbstractContextManager[Callable[[str], None]]: ...
    def progress_bar(self) -> AbstractContextManager[Callable[[float], None]]: ...
    def print_figures(self, title: str, figures: Any, table: object = None, /) -> None: ...
    def print_list(self, key: str, items: Iterable[Any], text: object, /) -> None: ...
