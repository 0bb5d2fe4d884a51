"""The start window without a window: what is typed, what is wrong with it, and which page comes next."""

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.start.state import NO_ADDRESS, NO_CODE, NO_PORT, CallTarget, StartState

CODE = "acorn-tulip-river-42"


def is_free(port: int) -> bool:
    return port != 5999


RELAY_CODE = "4711-acorn-tulip-river"
TYPED = StartState(address=" 10.0.0.7 ", code="Acorn Tulip, river 42", notice="nobody answered")


def test_a_call_is_made_to_the_typed_address() -> None:
    state = TYPED.call()
    assert (state.page, state.target, state.notice) == ("calling", CallTarget("10.0.0.7", 5005, CODE), "")
    assert state.target is not None and state.target.address == "10.0.0.7"


@pytest.mark.parametrize(
    ("address", "code", "address_error", "code_error"),
    [
        ("", "", NO_ADDRESS, NO_CODE),
        (" ", CODE, NO_ADDRESS, ""),
        ("host:99999", CODE, "host:99999 is not HOST:PORT; an IPv6 address is written [HOST]:PORT", ""),
        ("host", "acorn-tulip-rivr-42", "", "'rivr' is not a word of any code: did you mean 'river'?"),
        ("host", "acorn", "", "a code is three words and a number, such as acorn-tulip-river-42"),
    ],
)
def test_each_field_has_its_own_error(address: str, code: str, address_error: str, code_error: str) -> None:
    state = StartState(address=address, code=code).call()
    assert (state.page, state.target) == ("home", None)
    assert (state.address_error, state.code_error) == (address_error, code_error)
    typed = state.with_field("address", "other")
    assert typed.address_error == "" and typed.code_error == code_error
    assert state.with_field("code", code) is state


@given(st.text(), st.text())
def test_whatever_is_typed_gives_a_call_or_an_error(address: str, code: str) -> None:
    state = StartState(address=address, code=code).call()
    assert (state.target is None) == bool(state.address_error or state.code_error)


def test_waiting_shows_a_code_until_the_call_has_ended() -> None:
    state = TYPED.wait(CODE, is_free)
    assert (state.page, state.target, state.notice) == ("waiting", CallTarget(None, 5005, CODE), "")
    ended = state.connect().end_call("")
    assert (ended.page, ended.target, ended.connected) == ("home", None, False)
    assert ended.code == TYPED.code  # typed for another call


@pytest.mark.parametrize("port", ["", "0", "65536", "50x", "-1", "\N{SUPERSCRIPT TWO}"])
def test_a_port_is_a_number(port: str) -> None:
    state = StartState(port=port).wait(CODE, is_free)
    assert (state.page, state.port_error) == ("home", NO_PORT)
    assert StartState(port="5999").wait(CODE, is_free).port_error == "another program uses port 5999: choose another"
    assert StartState(port=" 6001 ").wait(CODE, is_free).target == CallTarget(None, 6001, CODE)


def test_a_code_is_kept_until_it_was_of_use() -> None:
    calling = TYPED.call()
    failed = calling.end_call("nobody answered")
    assert (failed.code, failed.address, failed.notice) == (TYPED.code, TYPED.address, "nobody answered")
    assert calling.connect().end_call("").code == ""


@pytest.mark.parametrize(
    ("host", "port", "address"),
    [("h", 5005, "h"), ("h", 6001, "h:6001"), ("::1", 5005, "[::1]"), (None, 5005, "0.0.0.0:5005")],
)
def test_an_address_is_written_as_it_is_typed(host: str | None, port: int, address: str) -> None:
    assert CallTarget(host, port, CODE).address == address


def test_a_name_is_checked_when_it_is_entered() -> None:
    assert replace(TYPED, name="Anna").enter_name().name_error == ""
    assert replace(TYPED, name="").enter_name().name_error == ""
    assert replace(TYPED, name="a" * 33).enter_name().name_error.startswith("expected at most 32 letters")


def test_errors_and_notice_can_be_cleared() -> None:
    assert not StartState(address="h").complains
    for state in (
        StartState().call(),
        StartState(port="x").wait(CODE, is_free),
        StartState(name="a\nb").enter_name(),
        TYPED,
    ):
        assert state.complains and not state.without_complaints().complains


def test_a_code_with_its_number_in_front_is_called_over_the_relay() -> None:
    typed = StartState(address="ignored", code=" 4711 Acorn tulip river", relay=" relay.example ")
    state = typed.call()
    assert (state.page, state.needs_address) == ("calling", False)
    assert state.target == CallTarget(None, 0, RELAY_CODE, relay="relay.example", nameplate="4711")
    assert (state.target.is_waiting, state.target.address) == (False, "4711")
    assert replace(typed, relay="").call().target == CallTarget(None, 0, RELAY_CODE, relay="", nameplate="4711")


@pytest.mark.parametrize(
    ("code", "relay", "code_error", "relay_error"),
    [
        ("4711 acorn tulip rivr", "", "'rivr' is not a word of any code: did you mean 'river'?", ""),
        ("4711", "", "a code for a relay is a number and three words, such as 4711-acorn-tulip-river", ""),
        (RELAY_CODE, "a b:c", "", "a b:c is not HOST:PORT; an IPv6 address is written [HOST]:PORT"),
    ],
)
def test_what_is_wrong_with_a_call_over_a_relay_is_said(
    code: str, relay: str, code_error: str, relay_error: str
) -> None:
    state = StartState(code=code, relay=relay).call()
    assert (state.page, state.code_error, state.relay_error) == ("home", code_error, relay_error)
    assert state.complains and not state.without_complaints().complains


def test_over_a_relay_the_code_is_known_later() -> None:
    state = replace(TYPED, relay="relay.example:99").wait_over_relay()
    assert (state.page, state.notice) == ("waiting", "")
    assert state.target == CallTarget(None, 0, "", relay="relay.example:99") and state.target.is_waiting
    shown = state.show_code(RELAY_CODE)
    assert shown.target and shown.target.code == RELAY_CODE and shown.page == "waiting"
    assert StartState().show_code(RELAY_CODE) == StartState()
    assert StartState(relay=":").wait_over_relay().page == "home"
