"""Which way a call goes, and which code it has, with a transport that is no network."""

import argparse
import os
import time
from contextlib import ExitStack
from pathlib import Path
from typing import Any
from unittest.mock import Mock

import pytest

from conf.call.view import Waiting
from conf.commands.support import relay_route
from conf.commands.support.relay_route import (
    NO_NAMEPLATE,
    OPEN_LIMIT_S,
    TRIES,
    RelayRoute,
    add_relay,
    call_over,
    call_target,
    code_to_call,
    describe_waiting,
    open_at,
    open_to,
    route_of,
    wait_over,
    waiting,
)
from conf.errors import ConfError, NetworkError
from conf.protocol.address import SocketAddress
from conf.protocol.receiver_endpoint import ReceiverEndpoint
from conf.protocol.sender_connection import SenderConnection
from conf.protocol.session.client import SenderSession
from conf.protocol.session.pairing_code import nameplate_of, normalise_code
from conf.protocol.session.server import SessionServer
from conf.transport.exchange import DatagramExchange
from tests.support.relay import free_port, router, wait_until
from tests.support.two_way_call import PARAMETERS

CODE = "4711-acorn-tulip-river"
ROUTE = RelayRoute(("relay.example", 7447))


class Clock:
    """Time that passes while somebody sleeps."""

    def __init__(self) -> None:
        self.now = 0.0

    def __call__(self) -> float:
        return self.now

    def sleep(self, seconds: float) -> None:
        self.now += seconds


class FakeTransport:
    """A transport of which a test sets what the relay says. made : all of them"""

    made: list["FakeTransport"]
    taken: set[int]
    opens = True

    def __init__(self, nameplate: str, credentials: Any) -> None:
        self.nameplate, self.credentials = nameplate, credentials
        self.is_closed = False
        self.note = "the relay does not answer or refuses the password"
        self.is_open = self.opens
        self.relay = self
        self.others_wait = len(self.made) in self.taken
        self.made.append(self)

    @classmethod
    def wait_at(cls, relay: tuple[str, int], nameplate: str, *, credentials: Any = None) -> "FakeTransport":
        assert relay == ROUTE.relay
        return cls(nameplate, credentials)

    call = wait_at

    def close(self) -> None:
        self.is_closed = True


@pytest.fixture
def fake(monkeypatch: pytest.MonkeyPatch) -> type[FakeTransport]:
    """Return the transport that commands use in a test."""
    transport = type("Fake", (FakeTransport,), {"made": [], "taken": set()})
    monkeypatch.setattr("conf.transport.traversal.TraversalTransport", transport)
    return transport


def wait(code: str = "", route: RelayRoute = ROUTE) -> tuple[FakeTransport, str]:
    clock = Clock()
    return wait_over(route, code, clock=clock, sleep=clock.sleep)  # type: ignore[return-value]


def test_who_waits_gets_a_code_with_a_free_number(fake: type[FakeTransport]) -> None:
    fake.taken = {0, 1, 2}
    transport, code = wait()
    assert nameplate_of(code) == transport.nameplate and len(fake.made) == 4
    assert [len(made.nameplate) for made in fake.made] == [4, 4, 5, 5]
    assert [made.is_closed for made in fake.made] == [True, True, True, False]


def test_the_number_of_a_given_code_must_be_free(fake: type[FakeTransport]) -> None:
    assert wait(CODE)[1] == CODE
    fake.taken = {1}
    with pytest.raises(NetworkError, match="somebody else waits with the number 4711"):
        wait(CODE)
    assert len(fake.made) == 2
    with pytest.raises(ConfError, match=NO_NAMEPLATE[:30]):
        wait("acorn-tulip-river-42")


def test_numbers_are_not_tried_for_ever(fake: type[FakeTransport]) -> None:
    fake.taken = set(range(100))
    with pytest.raises(NetworkError, match="somebody else waits with the number"):
        wait()
    assert len(fake.made) == TRIES and all(made.is_closed for made in fake.made)


def test_a_relay_that_does_not_answer_is_named(fake: type[FakeTransport]) -> None:
    fake.opens = False
    clock = Clock()
    with pytest.raises(NetworkError, match="does not answer or refuses the password"):
        wait_over(ROUTE, "", clock=clock, sleep=clock.sleep)
    assert OPEN_LIMIT_S < clock.now < OPEN_LIMIT_S + 1 and fake.made[0].is_closed


def test_a_password_is_read_from_its_file(fake: type[FakeTransport], tmp_path: Path) -> None:
    file = tmp_path / "password"
    file.write_text("ann:secret\n")
    route = RelayRoute(ROUTE.relay, file)
    assert wait(route=route)[0].credentials == ("ann", "secret")
    assert call_over(route, CODE).credentials == ("ann", "secret")  # type: ignore[attr-defined]
    assert call_over(ROUTE, CODE).credentials is None  # type: ignore[attr-defined]
    with pytest.raises(NetworkError, match="names no password"):
        file.write_text("")
        call_over(route, CODE)


def test_what_is_called_is_a_code_or_an_address() -> None:
    assert call_target("4711 Acorn tulip RIVER") == CODE
    assert call_target("4711") == "4711"
    assert call_target("relay.example:99") == ("relay.example", 99)
    with pytest.raises(argparse.ArgumentTypeError, match="did you mean 'river'"):
        call_target("4711-acorn-tulip-rivr")


class FakeTerminal:
    """A user who types one text, whatever the question."""

    def __init__(self, typed: str = "") -> None:
        self.typed = typed

    def ask(self, question: str, /) -> str:
        return self.typed


def test_words_need_not_be_on_the_command_line(monkeypatch: pytest.MonkeyPatch) -> None:
    def code(target: tuple[str, int] | str, given: str | None = None, typed: str = "") -> str:
        return code_to_call(target, given, FakeTerminal(typed), "the receiver")  # type: ignore[arg-type]

    monkeypatch.delenv("CONF_CODE", raising=False)
    assert code(CODE) == code("4711", CODE) == code("4711", typed="4711 Acorn tulip river") == CODE
    assert code(("10.0.0.7", 5005), typed="acorn tulip river 42") == "acorn-tulip-river-42"
    monkeypatch.setenv("CONF_CODE", CODE)
    assert code("4711") == CODE
    with pytest.raises(ConfError, match="the code 4711-acorn-tulip-river does not begin with 4712: give the code"):
        code("4712")
    monkeypatch.setenv("CONF_CODE", "4711")
    with pytest.raises(ConfError, match="such as 4711-acorn-tulip-river: give the one the receiver shows"):
        code("4711")


def test_who_listens_needs_no_relay() -> None:
    opened, code = open_at(("127.0.0.1", 0), ROUTE, "")
    with opened:
        assert normalise_code(code) == code and not nameplate_of(code)
        assert describe_waiting(opened, ROUTE) == f"listening on 127.0.0.1:{opened.address[1]}"
        with open_to(("127.0.0.1", int(opened.address[1])), ROUTE, code) as caller:
            assert caller.remote == opened.address
    with open_at(("127.0.0.1", 0), ROUTE, CODE)[0] as opened:
        assert opened.nameplate == ""


def test_without_a_host_one_waits_over_the_relay(fake: type[FakeTransport]) -> None:
    transport, code = open_at(None, ROUTE, "")
    assert transport is fake.made[-1] and nameplate_of(code) == transport.nameplate
    assert describe_waiting(transport, ROUTE) == "waiting over the relay relay.example"
    assert open_to("4711", ROUTE, CODE).nameplate == "4711"


@pytest.mark.slow
def test_two_senders_with_one_code_reach_a_receiver_over_a_relay_and_then_directly() -> None:
    port = free_port()
    route = RelayRoute(("127.0.0.1", port))
    with router(port), open_at(None, route, CODE)[0] as opened:
        receiver = ReceiverEndpoint(SessionServer(CODE, os.urandom))
        exchanges = [DatagramExchange(opened, receiver, peers=lambda: receiver.callers)]
        paths: dict[int, list[str]] = {}
        with ExitStack() as stack:
            for _ in range(2):
                socket = stack.enter_context(open_to("4711", route, CODE))
                assert socket.remote is not None
                session = SenderSession(CODE, socket.remote, os.urandom, time.monotonic())
                exchanges.append(DatagramExchange(socket, SenderConnection(session, PARAMETERS, time.monotonic())))

            def both_are_direct() -> bool:
                for exchange in exchanges:
                    exchange.receive(time.monotonic())
                    exchange.send(time.monotonic())
                for number, address in receiver.addresses.items():
                    name, names = opened.path_name(address), paths.setdefault(number, [])
                    names += [name] if name not in names else []
                return len(paths) == 2 and all(names[-1] == "direct" for names in paths.values())

            wait_until(both_are_direct)
    assert sorted(paths.values()) == [["relay", "direct"]] * 2


def test_the_options_name_the_relay(monkeypatch: pytest.MonkeyPatch) -> None:
    parser = argparse.ArgumentParser()
    add_relay(parser)
    monkeypatch.delenv(relay_route.PASSWORD_VARIABLE, raising=False)
    assert route_of(parser.parse_args([])) == RelayRoute()
    assert route_of(parser.parse_args(["--relay", "r.example"])) == RelayRoute(("r.example", 7447))
    assert route_of(parser.parse_args(["--relay-password", "a"])).password == Path("a")
    monkeypatch.setenv(relay_route.PASSWORD_VARIABLE, "b")
    assert route_of(parser.parse_args([])).password == Path("b")
    assert (ROUTE.name, RelayRoute().name) == ("the relay relay.example", "the local network")


@pytest.mark.parametrize(
    ("address", "expected"),
    [
        (("192.0.2.1", 5005), Waiting("192.0.2.1:5005", CODE, hosts=("192.0.2.1",))),
        (("0.0.0.0", 5005), Waiting("port 5005", CODE, hosts=("10.0.0.7", "fd00::7"))),
        (("::", 6001, 0, 0), Waiting("port 6001", CODE, hosts=("10.0.0.7:6001", "[fd00::7]:6001"))),
    ],
)
def test_who_waits_sees_where_it_is_called(
    monkeypatch: pytest.MonkeyPatch, address: SocketAddress, expected: Waiting
) -> None:
    monkeypatch.setattr("conf.transport.local_addresses.find_route_addresses", lambda: ("10.0.0.7", "fd00::7"))
    socket = Mock(remote=None, address=address, nameplate="")
    assert waiting(socket, RelayRoute(), None, CODE) == expected


@pytest.mark.parametrize(("port", "typed"), [(7447, "r.example"), (7000, "r.example:7000")])
def test_who_waits_over_a_relay_sees_which_one_the_other_names(port: int, typed: str) -> None:
    route = RelayRoute(("r.example", port))
    expected = Waiting("the relay r.example", "4711-acorn-tulip-river", "4711", relay=typed)
    socket = Mock(remote=None, nameplate="4711")
    assert waiting(socket, route, None, expected.code) == expected
    route, expected = RelayRoute(), Waiting("the local network", expected.code, "4711")
    assert waiting(socket, route, None, expected.code) == expected
