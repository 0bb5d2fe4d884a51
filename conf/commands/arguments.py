"""Options that several commands have, and the functions that convert their values."""

import argparse

DEFAULT_HOST = "127.0.0.1"
DEFAULT_PORT = 5005
AXES = ("x", "-x", "y", "-y", "z", "-z")


def add_json(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--json", action="store_true", help="print one JSON object and nothing else")


def add_seconds(parser: argparse.ArgumentParser, note: str = "") -> None:
    parser.add_argument("--seconds", type=positive_number, help=f"stop after this time{note}")


def add_listen(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--listen",
        type=address,
        default=(DEFAULT_HOST, DEFAULT_PORT),
        metavar="HOST:PORT",
        help=f"default {DEFAULT_HOST}:{DEFAULT_PORT}; 0.0.0.0:{DEFAULT_PORT} accepts calls from the network",
    )


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
    """Return host and port of HOST, HOST:PORT or [HOST]:PORT."""
    host, colon, port = text.rpartition(":")
    if not colon or (host.count(":") and not host.startswith("[")):
        host, port = text, str(DEFAULT_PORT)
    if not host or not port.isdigit() or not int(port) < 65536:
        raise argparse.ArgumentTypeError(f"{text} is not HOST:PORT")
    return host.strip("[]"), int(port)
