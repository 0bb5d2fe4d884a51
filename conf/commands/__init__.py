"""The commands, one module each, and the terminal in which they print.

A module has HELP, add_arguments(parser), which adds the command's options, and run(options, terminal), which executes
it, prints through the terminal that cli.py passes in and raises ConfError. `conf --help` imports all of these modules:
to keep it fast they import NumPy, OpenCV and most of conf inside their functions.
"""

import json
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import asdict
from typing import Any


class Terminal:
    """Where a command prints. --json moves messages to stderr and hides progress."""

    def __init__(self, *, json: bool) -> None:
        self._json = json

    def write(self, text: str, /) -> None:
        """Print a line."""
        print(text, file=sys.stderr if self._json else sys.stdout, flush=True)

    def ask(self, question: str, /) -> str:
        """Return a line from the user; empty if nobody can answer."""
        return input(question) if sys.stdin.isatty() else ""

    @contextmanager
    def status_line(self) -> Iterator[Callable[[str], None]]:
        """Show a line while a command runs; yields the function that sets its text."""
        from rich.console import Console

        with Console(stderr=True, quiet=self._json).status("starting") as status:
            yield status.update

    @contextmanager
    def progress_bar(self) -> Iterator[Callable[[float], None]]:
        """Show a bar while a command runs; yields the function that sets its fraction, 0 to 1."""
        from rich.console import Console
        from rich.progress import Progress

        with Progress(console=Console(stderr=True), transient=True, disable=self._json) as progress:
            task = progress.add_task("writing", total=1.0)
            yield lambda fraction: progress.update(task, completed=fraction)

    def print_figures(self, title: str, figures: Any, /) -> None:
        """Print a dataclass as a table, or as one JSON object."""
        values = asdict(figures)
        if self._json:
            print(json.dumps({name: round(v, 3) if isinstance(v, float) else v for name, v in values.items()}))
            return
        from rich.console import Console
        from rich.table import Table

        table = Table(title=title, show_header=False, title_justify="left")
        nested = [item for value in values.values() if isinstance(value, dict) for item in value.items()]
        for name, value in [*values.items(), *nested]:
            if not isinstance(value, dict):
                table.add_row(name.replace("_", " "), f"{value:,.1f}" if isinstance(value, float) else str(value))
        Console().print(table)

    def print_list(self, key: str, items: Iterable[Any], text: object, /) -> None:
        """Print a text or rich table that describes dataclasses, or one JSON object with a list of them."""
        if self._json:
            print(json.dumps({key: [asdict(item) for item in items]}))
        elif isinstance(text, str):
            print(text)
        else:
            from rich.console import Console

            Console().print(text)
