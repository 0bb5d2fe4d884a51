import argparse

import pytest

from conf.cli import build_parser
from conf.commands.support.arguments import (
    add_json,
    add_listen,
    add_seconds,
    address,
    join_axis_options,
    link_rate,
    listen_address,
    pairing_code,
    positive_number,
)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("example.org", ("example.org", 5005)),
        ("10.0.0.1:6000", ("10.0.0.1", 6000)),
        ("[::1]:6000", ("::1", 6000)),
        ("::1", ("::1", 5005)),
        ("fe80::1%eth0", ("fe80::1%eth0", 5005)),
        ("[fe80::1%eth0]:6000", ("fe80::1%eth0", 6000)),
    ],
)
def test_an_address_is_a_host_with_an_optional_port(text: str, expected: tuple[str, int]) -> None:
    assert address(text) == expected


@pytest.mark.parametrize("text", ["host:port", "127.0.0.1:99999", ""])
def test_an_invalid_address_is_an_error(text: str) -> None:
    with pytest.raises(argparse.ArgumentTypeError, match="is not HOST:PORT"):
        address(text)


@pytest.mark.parametrize("text", ["localhost:0", "[::1]:0"])
def test_nobody_can_be_called_at_port_0(text: str) -> None:
    with pytest.raises(argparse.ArgumentTypeError, match="names no port: give the one that the receiver shows"):
        address(text)


@pytest.mark.parametrize("text", ["-1", "0", "inf", "nan", "x", ""])
def test_a_number_must_be_positive_and_finite(text: str) -> None:
    assert positive_number("0.5") == 0.5
    with pytest.raises(argparse.ArgumentTypeError, match="is not a positive number"):
        positive_number(text)


@pytest.mark.parametrize(
    ("text", "message"), [("0.9", "0.9 kbit/s carries no call: give 1 or more"), ("x", "x is not a positive number")]
)
def test_a_link_must_carry_a_call(text: str, message: str) -> None:
    assert link_rate("1") == 1.0
    with pytest.raises(argparse.ArgumentTypeError, match=f"^{message}$"):
        link_rate(text)


def test_a_pairing_code_is_normalised() -> None:
    assert pairing_code("Amber canoe tiger 7") == "amber-canoe-tiger-7"
    with pytest.raises(argparse.ArgumentTypeError):
        pairing_code("x")


def test_defaults_of_the_common_options() -> None:
    parser = argparse.ArgumentParser()
    for add in (add_json, add_listen, add_seconds):
        add(parser)
    options = parser.parse_args([])
    assert (options.json, options.listen, options.seconds) == (False, None, None)
    parser = argparse.ArgumentParser()
    add_listen(parser, default=("127.0.0.1", 5005))
    assert parser.parse_args([]).listen == ("127.0.0.1", 5005)
    assert "default 127.0.0.1:5005; a port alone" in parser.format_help()


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("5005", ("", 5005)),
        (":5005", ("", 5005)),
        ("127.0.0.1:0", ("127.0.0.1", 0)),
        ("[::]:6001", ("::", 6001)),
        ("[::1]", ("::1", 5005)),
        ("localhost", ("localhost", 5005)),
    ],
)
def test_a_port_alone_listens_on_every_address(text: str, expected: tuple[str, int]) -> None:
    assert listen_address(text) == expected


def test_axes_are_typed_with_or_without_an_equals_sign() -> None:
    typed = ["fit", "a.obj", "--up", "-z", "--front=-y", "--fr", "x", "-o", "-y", "--", "-z"]
    assert join_axis_options(typed) == ["fit", "a.obj", "--up=-z", "--front=-y", "--fr=x", "-o", "-y", "--", "-z"]
    assert join_axis_options(["--up", "here", "--front"]) == ["--up", "here", "--front"]
    assert join_axis_options([]) == []


@pytest.mark.parametrize("command", ["fit", "animate"])
def test_the_parser_accepts_negative_axes(command: str) -> None:
    options = build_parser().parse_args(join_axis_options([command, "a.obj", "--up", "-z", "--front", "-y"]))
    assert (options.up, options.front) == ("-z", "-y")
