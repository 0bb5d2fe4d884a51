"""The commands, one module each.

A module has HELP, add_arguments(parser), which adds the command's options, and run(options, terminal), which executes
it, prints through the terminal that cli.py passes in and raises ConfError. `conf --help` imports all of these modules:
to keep it fast they import NumPy, OpenCV and most of conf inside their functions.
"""

from collections.abc import Callable, Iterable
from contextlib import AbstractContextManager
from typing import Any, Protocol


class Terminal(Protocol):
    """Where a command prints; cli.py implements it. --json moves messages to stderr and hides progress."""

    def write(self, text: str, /) -> None:
        """Print a line."""

    def ask(self, question: str, /) -> str:
        """Return a line from the user; empty if nobody can answer."""

    def status_line(self) -> AbstractContextManager[Callable[[str], None]]:
        """Show a line while a command runs; yields the function that sets its text."""

    def progress_bar(self) -> AbstractContextManager[Callable[[float], None]]:
        """Show a bar while a command runs; yields the function that sets its fraction, 0 to 1."""

    def print_figures(self, title: str, figures: Any, /) -> None:
        """Print a dataclass as a table, or as one JSON object."""

    def print_list(self, key: str, items: Iterable[Any], text: object, /) -> None:
        """Print a text or rich table that describes dataclasses, or one JSON object with a list of them."""
