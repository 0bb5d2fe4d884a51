"""Defaults of options from the user's settings; what is given on the command line wins."""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from conf.commands.support.arguments import relay_address
from conf.errors import ConfError
from conf.settings import NAMES

if TYPE_CHECKING:
    from conf.settings import Settings

# A microphone that is only a setting does not replace the sound that belongs to what was given instead of a camera.
RELAY_VARIABLE = "CONF_RELAY"
_SETTING_IGNORED_WITH = {"microphone": ("file", "dpc", "sound")}


@dataclass(frozen=True)
class _NotGiven:
    """The value of an option that was not given. default : what holds without a setting"""

    default: Any


def mark_defaults(parser: argparse.ArgumentParser, /) -> None:
    """Make the options of a command that have a setting tell whether they were given."""
    dests = [action.dest for action in parser._actions if action.option_strings and action.dest in NAMES]
    parser.set_defaults(**{dest: _NotGiven(parser.get_default(dest)) for dest in dests})


def apply_settings(options: argparse.Namespace, load: Callable[[], Settings], /) -> None:
    """Give options that were not given the values of the settings, or their own defaults.

    load : reads the settings; called only if the command has such options
    """
    values = vars(options)
    not_given = {name: value for name, value in values.items() if isinstance(value, _NotGiven)}
    if not not_given:
        return
    settings = load()
    for name, value in not_given.items():
        setting = getattr(settings, name)
        is_ignored = any(values.get(other) is not None for other in _SETTING_IGNORED_WITH.get(name, ()))
        values[name] = value.default if setting is None or is_ignored else setting
    if "relay" in not_given and (relay := os.environ.get(RELAY_VARIABLE) or settings.relay):
        values["relay"] = _relay(relay)


def _relay(text: str) -> tuple[str, int]:
    """Return host and port of a relay. Raises ConfError."""
    try:
        return relay_address(text)
    except argparse.ArgumentTypeError as error:
        raise ConfError(f"relay: {error}") from error
