"""The command line: the only module that prints and exits.

Exit status: 0 success, 1 an error, explained in one line on stderr, 2 wrong usage. With --json a command prints one
JSON object and nothing else.
"""

import argparse
import json
import os
import signal
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import asdict
from typing import Any, NoReturn

from conf import __version__
from conf.commands import (
    animate,
    call,
    demo,
    devices,
    doctor,
    export,
    extract,
    fit,
    heads,
    measure,
    models,
    receive,
    relay,
    send,
    settings,
)
from conf.commands.start import open_start_window
from conf.commands.support.arguments import join_axis_options
from conf.commands.support.display import has_display
from conf.commands.support.interruption import InterruptHandler, check_interrupt
from conf.commands.support.option_defaults import apply_settings, mark_defaults
from conf.commands.support.suggesting_parser import SuggestingParser
from conf.errors import ConfError, FileFormatError, explain
from conf.settings import Settings, load_settings, settings_path

COMMANDS = {
    "demo": demo, "call": call, "receive": receive, "send": send, "extract": extract, "animate": animate,
    "export": export, "fit": fit, "heads": heads, "measure": measure, "models": models,
    "devices": devices, "relay": relay, "doctor": doctor, "settings": settings,
}  # fmt: skip
WITH_SETTINGS = {"call", "receive", "send", "doctor"}  # commands whose options have the user's settings as defaults

INTERRUPTED = 130  # exit status, as shells report it
PIPE_WIDTH = 120  # columns of a table that is not printed on a terminal


def main(arguments: list[str] | None = None) -> None:
    """Run one command and exit."""
    for variable in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"):
        os.environ.setdefault(variable, "1")  # before NumPy is imported: idle BLAS threads delay frames by milliseconds
    on_interrupt = InterruptHandler()
    try:
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, on_interrupt)
        _run(sys.argv[1:] if arguments is None else arguments)
    except ConfError as error:
        sys.exit(f"conf: {explain(error)}")
    except KeyboardInterrupt as interrupt:
        _exit_interrupted(interrupt)
    except BrokenPipeError:
        with suppress(OSError):
            sys.stdout.close()
        sys.exit(1)
    except Exception as error:
        if on_interrupt.was_called:  # a library has raised another exception in its place
            _exit_interrupted(error)
        if os.environ.get("CONF_DEBUG"):
            raise
        sys.exit(f"conf: {type(error).__name__}: {error} (an error in conf itself; set CONF_DEBUG=1 for details)")
    sys.exit(0)


def _run(arguments: list[str]) -> None:
    """Run a command; without one open the start window, or print the help where no window can be opened."""
    parser = build_parser()
    if not arguments:
        if has_display():
            open_start_window()
        else:
            parser.print_help()
        return
    options = parser.parse_args(join_axis_options(arguments))
    apply_settings(options, _load_settings)
    options.run(options, _Terminal(json=getattr(options, "json", False)))


def _load_settings() -> Settings:
    """Return the user's settings; of a file that cannot be read the defaults, which are said not to be its."""
    try:
        return load_settings(settings_path())
    except FileFormatError as error:
        print(f"conf: the settings are ignored: {explain(error)}", file=sys.stderr)
        return Settings()


def _exit_interrupted(interrupt: BaseException) -> NoReturn:
    """Exit; the notes of the exception say which files were being written."""
    notes = getattr(interrupt, "__notes__", ())
    if notes:
        print(f"conf: interrupted: {'; '.join(notes)}", file=sys.stderr)
    sys.exit(INTERRUPTED)


def build_parser() -> argparse.ArgumentParser:
    """Return the parser of all commands; each sets `run` to the function that executes it."""
    parser = SuggestingParser(prog="conf", description="A video conference for links that cannot carry video.")
    parser.add_argument("--version", action=_PrintVersion, nargs=0, help="print the version and exit")
    subparsers = parser.add_subparsers(title="commands", required=True, metavar="COMMAND")
    for name, command in COMMANDS.items():
        subparser = subparsers.add_parser(name, help=command.HELP, description=command.HELP)
        command.add_arguments(subparser)
        if name in WITH_SETTINGS:
            mark_defaults(subparser)
        subparser.set_defaults(run=command.run, parser=subparser)
    return parser


class _PrintVersion(argparse.Action):
    def __call__(self, parser: argparse.ArgumentParser, *_: Any) -> None:
        print(f"conf {__version__}")
        parser.exit()


class _Terminal:
    """The terminal of commands.Terminal."""

    def __init__(self, *, json: bool) -> None:
        self._json = json

    def write(self, text: str, /) -> None:
        print(text, file=sys.stderr if self._json else sys.stdout, flush=True)

    def ask(self, question: str, /) -> str:
        return input(question) if sys.stdin.isatty() else ""

    @contextmanager
    def status_line(self) -> Iterator[Callable[[str], None]]:
        from rich.console import Console

        def show(text: str) -> None:
            check_interrupt()
            status.update(text)

        with Console(stderr=True, quiet=self._json).status("starting") as status:
            yield show

    @contextmanager
    def progress_bar(self) -> Iterator[Callable[[float], None]]:
        from rich.console import Console
        from rich.progress import Progress

        def show(fraction: float) -> None:
            check_interrupt()
            progress.update(task, completed=fraction)

        is_hidden = self._json or not sys.stderr.isatty()
        with Progress(console=Console(stderr=True), transient=True, disable=is_hidden) as progress:
            task = progress.add_task("writing", total=1.0)
            yield show

    def print_figures(self, title: str, figures: Any, table: object = None, /) -> None:
        values = asdict(figures)
        if self._json:
            print(json.dumps(_rounded(values)))
            return
        if table is not None:
            self._print(table)
            return
        from rich.table import Table

        rows = Table(title=title, show_header=False, title_justify="left")
        nested = [item for value in values.values() if isinstance(value, dict) for item in value.items()]
        for name, value in [*values.items(), *nested]:
            if not isinstance(value, dict):
                rows.add_row(name.replace("_", " "), f"{value:,.1f}" if isinstance(value, float) else str(value))
        self._print(rows)

    def print_list(self, key: str, items: Iterable[Any], text: object, /) -> None:
        if self._json:
            print(json.dumps({key: [asdict(item) for item in items]}))
        else:
            self._print(text)

    def _print(self, text: object) -> None:
        """Print a text or a rich table on stdout."""
        if isinstance(text, str):
            print(text)
            return
        from rich.console import Console

        Console(width=None if sys.stdout.isatty() else PIPE_WIDTH).print(text)


def _rounded(value: Any) -> Any:
    """Return JSON data with its numbers rounded to three decimals."""
    match value:
        case float():
            return round(value, 3)
        case dict():
            return {name: _rounded(item) for name, item in value.items()}
        case list() | tuple():
            return [_rounded(item) for item in value]
    return value
