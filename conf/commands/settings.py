"""`conf settings`: show and change the defaults of options."""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from typing import TYPE_CHECKING

from conf.commands import Terminal
from conf.commands.support.arguments import add_json

if TYPE_CHECKING:
    from conf.settings import Settings

HELP = "show and change the settings: defaults of options"
# setting -> what it is, what holds without it
DESCRIPTIONS = {
    "name": ("your name, which others see", "none"),
    "camera": ("number or device, as `conf devices` lists it", "0"),
    "microphone": ("number or name, as `conf devices` lists it", "the system's"),
    "speaker": ("number or name, as `conf devices` lists it", "the system's"),
    "portrait": ("whether images of you may be sent: true or false", "false"),
    "kbps": ("never more kbit/s than this", "no limit"),
    "voice": ("auto, opus, codec2 or off", "auto"),
    "face": ("the mesh that others are drawn with", "the shipped heads"),
    "head": ("the head that you are drawn with, one of `conf heads`", "a free one"),
    "relay": ("HOST or HOST:PORT of the relay for calls", "none: the local network is searched"),
}


@dataclass(frozen=True)
class SettingsReport:
    """Where the settings are, and the value of each; None where the command's own default holds."""

    path: str
    settings: dict[str, str | float | bool | None]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    help_text = f"set these: {', '.join(DESCRIPTIONS)}; NAME= without a value unsets one"
    parser.add_argument("changes", nargs="*", type=assignment, metavar="NAME=VALUE", help=help_text)
    add_json(parser)


def assignment(text: str) -> tuple[str, object]:
    """Return name and value of NAME=VALUE."""
    from conf.settings import parse_assignment

    try:
        return parse_assignment(text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from error


def run(options: argparse.Namespace, terminal: Terminal) -> None:
    from conf.settings import change_settings, load_settings, settings_path

    path = settings_path()
    if options.changes:
        settings, kept_aside = change_settings(path, dict(options.changes))
        if kept_aside:
            terminal.write(f"the former file could not be read and is kept as {kept_aside}")
    else:
        settings = load_settings(path)
    report = SettingsReport(str(path), json_values(settings))
    terminal.print_figures("settings", report, describe_settings(report))


def json_values(settings: Settings, /) -> dict[str, str | float | bool | None]:
    """Return the settings as JSON takes them."""
    values = {name: getattr(settings, name) for name in DESCRIPTIONS}
    return {name: value if isinstance(value, bool | float | None) else str(value) for name, value in values.items()}


def describe_settings(report: SettingsReport, /) -> str:
    """Return the path and a line for each setting: name, value, meaning."""
    values = {name: _text(value, DESCRIPTIONS[name][1]) for name, value in report.settings.items()}
    width = max(map(len, values.values()))
    lines = (f"  {name:<10}  {text:<{width}}  {DESCRIPTIONS[name][0]}" for name, text in values.items())
    return "\n".join((f"{report.path}:", *lines))


def _text(value: str | float | bool | None, default: str) -> str:
    match value:
        case None:
            return f"not set: {default}"
        case bool():
            return "true" if value else "false"
        case float():
            return f"{value:.10g}"
    return value
