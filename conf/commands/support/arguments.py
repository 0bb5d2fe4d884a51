"""Options that several commands have, and the functions that convert their values."""

import argparse
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

from conf.protocol.address import DEFAULT_RELAY_PORT, parse_address, parse_listen_address
from conf.settings import MIN_KBPS

AXES = ("x", "-x", "y", "-y", "z", "-z")
AXIS_OPTIONS = ("--up", "--front")


def add_json(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--json", action="store_true", help="print one JSON object and nothing else")


def add_seconds(parser: argparse.ArgumentParser, note: str = "") -> None:
    parser.add_argument("--seconds", type=positive_number, help=f"stop after this time{note}")


def add_face(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--face", type=Path, metavar="FILE", help="another face: a mesh with its PPC beside it")


def add_headless(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--headless", type=Path, metavar="OUT.mp4", help="no window: record this clip, MP4 or AVI")


def add_listen(parser: argparse.ArgumentParser, *, default: tuple[str, int] | None = None) -> None:
    """default : host and port, None if the option decides whether there is one"""
    meaning = "wait to be called here, without a relay" if default is None else f"default {default[0]}:{default[1]}"
    parser.add_argument(
        "--listen",
        type=listen_address,
        default=default,
        metavar="[HOST:]PORT",
        help=f"{meaning}; a port alone accepts calls from the network, IPv4 and IPv6",
    )


def join_axis_options(arguments: Sequence[str]) -> list[str]:
    """Return the arguments with `--front -y` as `--front=-y`: argparse takes the value for an option otherwise."""
    joined: list[str] = []
    for argument in arguments:
        option = joined[-1] if joined else ""
        is_axis = len(option) > 2 and any(name.startswith(option) for name in AXIS_OPTIONS)  # also abbreviated
        if is_axis and argument in AXES:
            joined[-1] = f"{option}={argument}"
        else:
            joined.append(argument)
    return joined


def positive_number(text: str) -> float:
    """Return a finite number above 0."""
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not 0 < value < float("inf"):
        raise argparse.ArgumentTypeError(f"{text} is not a positive number")
    return value


def link_rate(text: str) -> float:
    """Return a rate in kbit/s at which a call is possible."""
    rate = positive_number(text)
    if rate < MIN_KBPS:
        raise argparse.ArgumentTypeError(f"{text} kbit/s carries no call: give {MIN_KBPS} or more")
    return rate


def pairing_code(text: str) -> str:
    """Return a pairing code in its normal form."""
    from conf.protocol.session.pairing_code import normalise_code

    try:
        return normalise_code(text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from error


def relay_address(text: str) -> tuple[str, int]:
    """Return host and port of a relay as `address`; without a port that of relays."""
    return _parsed(partial(parse_address, default_port=DEFAULT_RELAY_PORT), text)


def relay_listen_address(text: str) -> tuple[str, int]:
    """Return host and port as `listen_address`; without a port that of relays."""
    return _parsed(partial(parse_listen_address, default_port=DEFAULT_RELAY_PORT), text)


def address(text: str) -> tuple[str, int]:
    """Return host and port of HOST, HOST:PORT, [HOST]:PORT or [HOST]; without a port the default one."""
    return _parsed(parse_address, text)


def listen_address(text: str) -> tuple[str, int]:
    """Return host and port as `address`; a port alone, or :PORT, stands for every address of this machine.

    Port 0 is any free one.
    """
    return _parsed(parse_listen_address, text)


def _parsed(parse: Callable[[str], tuple[str, int]], text: str) -> tuple[str, int]:
    try:
        return parse(text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from error
