"""The command line: the only module that exits.

Exit status: 0 success, 1 an error, explained in one line on stderr, 2 wrong usage. With --json a command prints one
JSON object and nothing else.
"""

import argparse
import os
import signal
import sys
from contextlib import suppress
from typing import Any

from conf.commands import Terminal, animate, demo, doctor, export, extract, fit, measure, models, receive, send
from conf.errors import ConfError

COMMANDS = {
    "demo": demo, "receive": receive, "send": send, "extract": extract, "animate": animate,
    "export": export, "fit": fit, "measure": measure, "models": models, "doctor": doctor,
}  # fmt: skip


def main(arguments: list[str] | None = None) -> None:
    """Run one command and exit."""
    for variable in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"):
        os.environ.setdefault(variable, "1")  # before NumPy is imported: idle BLAS threads delay frames by milliseconds
    options = build_parser().parse_args(arguments)
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        options.run(options, Terminal(json=getattr(options, "json", False)))
    except ConfError as error:
        sys.exit(f"conf: {error}")
    except KeyboardInterrupt:
        sys.exit(130)
    except BrokenPipeError:
        with suppress(OSError):
            sys.stdout.close()
        sys.exit(1)
    except Exception as error:
        if os.environ.get("CONF_DEBUG"):
            raise
        sys.exit(f"conf: {type(error).__name__}: {error} (an error in conf itself; set CONF_DEBUG=1 for details)")
    sys.exit(0)


def build_parser() -> argparse.ArgumentParser:
    """Return the parser of all commands; each sets `run` to the function that executes it."""
    parser = argparse.ArgumentParser(prog="conf", description="A video conference for links that cannot carry video.")
    parser.add_argument("--version", action=_PrintVersion, nargs=0, help="print the version and exit")
    subparsers = parser.add_subparsers(required=True, metavar="COMMAND")
    for name, command in COMMANDS.items():
        subparser = subparsers.add_parser(name, help=command.HELP, description=command.HELP)
        command.add_arguments(subparser)
        subparser.set_defaults(run=command.run)
    return parser


class _PrintVersion(argparse.Action):
    def __call__(self, parser: argparse.ArgumentParser, *_: Any) -> None:
        from importlib.metadata import version

        print(f"conf {version('conf')}")
        parser.exit()
