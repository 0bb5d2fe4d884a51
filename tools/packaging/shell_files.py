"""Make the manual page and the completions of bash, zsh and fish from the parser of the command line.

setup.py calls this in every build; the wheel installs the files where shells and `man` look for them, below the prefix
of the installation: share/man/man1, share/bash-completion/completions and so on. To look at them:

    python tools/packaging/shell_files.py FOLDER
"""

import argparse
import os
import sys
from pathlib import Path
from unittest import mock

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import shtab
from argparse_manpage.manpage import Manpage

from conf import __version__
from conf.cli import build_parser

PROGRAM = "conf"
MANUAL = "share/man/man1/conf.1"
COMPLETIONS = {
    "bash": "share/bash-completion/completions/conf",
    "zsh": "share/zsh/site-functions/_conf",
    "fish": "share/fish/vendor_completions.d/conf.fish",
}
WIDTH = "1000"  # columns at which argparse breaks the lines of a usage: never, as `man` fits them to the terminal
# Sections of the manual page that the parser does not know: heading, text in the language of troff.
SECTIONS = {
    "examples": r"""
.TP
conf
A window to call somebody or to be called, and to choose camera, microphone and speaker.
.TP
conf call \-\-listen 5005
Wait to be called, and print a code such as acorn\-tulip\-river\-42.
.TP
conf call HOST \-\-code acorn\-tulip\-river\-42
Call: face and voice go both ways.
.TP
conf call \-\-relay HOST
Wait to be called over a relay, and print a code such as 4711\-acorn\-tulip\-river.
.TP
conf call 4711 \-\-relay HOST
Call over the relay; the code is asked for.
.TP
conf receive \-\-listen 5005
On the machine that shows the face. It prints a code such as acorn\-tulip\-river\-42.
.TP
conf send HOST \-\-code acorn\-tulip\-river\-42
On the machine with the camera and the microphone.
.TP
conf demo
Both on this machine, with a clip as the camera.
.TP
conf doctor
What works on this machine, and what to do about the rest.
""",
    "environment": r"""
.TP
CONF_CODE
The code for conf send and conf call, instead of \-\-code, which other users of the machine can read.
.TP
CONF_RELAY
HOST or HOST:PORT of the relay for conf call, conf send and conf receive, instead of \-\-relay.
.TP
CONF_RELAY_PASSWORD
A file with the user:password of the relay, instead of \-\-relay\-password.
.TP
CONF_MODELS
The folder of the tracker's files; by default one in the user's cache.
.TP
CONF_SETTINGS
The settings file; by default settings.toml in the user's folder of settings.
.TP
CONF_DEBUG
If set, an error in conf itself is shown with its traceback.
""",
    "files": r"""
.TP
settings.toml
Defaults of options, in the user's folder of settings (~/.config/conf); conf settings prints its path.
.TP
recent_calls.json
The last 20 calls of the start window by name, address and time, never with their codes, in the user's folder of state
(~/.local/state/conf).
""",
    "exit status": (
        "0 success, also if Ctrl\\-C ends a call; 1 an error, explained in one line on standard error; 2 wrong usage; "
        "130 anything else that Ctrl\\-C ends."
    ),
}


def write_shell_files(folder: Path, /) -> list[tuple[str, list[str]]]:
    """Write all files below a folder and return them as setuptools' data_files: (target folder, [path])."""
    with mock.patch.dict(os.environ, COLUMNS=WIDTH):
        texts = {MANUAL: manual_page()} | {path: completion(shell) for shell, path in COMPLETIONS.items()}
    for name, text in texts.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    return [(os.path.dirname(name), [(folder / name).as_posix()]) for name in texts]


def manual_page() -> str:
    """Return the manual page in the language of troff."""
    parser = build_parser()
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for subparser in action.choices.values():
                subparser.description = None  # the same as its line in the list of commands
    data = {
        "project_name": PROGRAM,
        "version": __version__,
        "description": "video conference that sends voice, and control points instead of video",
        "manual_title": "User Commands",
    }
    page = Manpage(parser, data, format="single-commands-section")
    for heading, text in SECTIONS.items():
        page.add_section(heading, ">", text.strip())
    return str(page)


def completion(shell: str, /) -> str:
    """Return the completion script for bash, zsh or fish; arguments that are paths complete to files."""
    parser = build_parser()
    complete_paths(parser)
    return str(shtab.complete(parser, shell=shell))


def complete_paths(parser: argparse.ArgumentParser, /) -> None:
    """Mark each argument of a parser and its subparsers that is a path as one that completes to files."""
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for subparser in action.choices.values():
                complete_paths(subparser)
        elif action.type is Path:
            action.complete = shtab.FILE  # type: ignore[attr-defined]


if __name__ == "__main__":
    write_shell_files(Path(sys.argv[1]))
