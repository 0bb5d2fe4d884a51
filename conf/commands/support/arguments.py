"""Options that several commands have, and the functions that convert their values."""

import argparse
import re
from collections.abc import Sequence

DEFAULT_HOST = "127.0.0.1"
DEFAULT_PORT = 5005
# [HOST]:PORT, HOST:PORT, or an IPv6 address without brackets, which has no port
_ADDRESS = re.compile(
    r"(?:\[(?P<bracketed>[^\]]+)\]|(?P<bare>[^:\[\]]*:[^\[\]]*:[^\[\]]*)|(?P<host>[^:\[\]]+))(?::(?P<port>\d{1,5}))?"
)
AXES = ("x", "-x", "y", "-y", "z", "-z")
AXIS_OPTIONS = ("--up", "--front")


def add_json(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--json", action="store_true", help="print one JSON object and nothing else")


def add_seconds(parser: argparse.ArgumentParser, note: str = "") -> None:
    parser.add_argument("--seconds", type=positive_number, help=f"stop after this time{note}")


def add_listen(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--listen",
        type=listen_address,
        default=(DEFAULT_HOST, DEFAULT_PORT),
        metavar="[HOST:]PORT",
        help=f"default {DEFAULT_HOST}:{DEFAULT_PORT}; a port alone accepts calls from the network, IPv4 and IPv6",
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
    value = float(text)
    if not 0 < value < float("inf"):
        raise argparse.ArgumentTypeError(f"{text} is not a positive number")
    return value


def pairing_code(text: str) -> str:
    """Return a pairing code in its normal form."""
    from conf.protocol.session.pairing_code import normalise_code

    try:
        return normalise_code(text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from error


def address(text: str) -> tuple[str, int]:
    """Return host and port of HOST, HOST:PORT, [HOST]:PORT or [HOST]; without a port the default one."""
    host, port = _host_and_port(text)
    if port == 0:
        raise argparse.ArgumentTypeError(f"{text} names no port: give the one that the receiver shows")
    return host, port


def listen_address(text: str) -> tuple[str, int]:
    """Return host and port as `address`; a port alone, or :PORT, stands for every address of this machine.

    Port 0 is any free one.
    """
    port = text.removeprefix(":")
    if port.isdigit() and int(port) < 65536:
        return "", int(port)
    return _host_and_port(text)


def _host_and_port(text: str) -> tuple[str, int]:
    match = _ADDRESS.fullmatch(text)
    if match is None or int(match["port"] or DEFAULT_PORT) > 65535:
        raise argparse.ArgumentTypeError(f"{text} is not HOST:PORT; an IPv6 address is written [HOST]:PORT")
    return match["bracketed"] or match["host"] or match["bare"], int(match["port"] or DEFAULT_PORT)
