import socket
from pathlib import Path

import pytest

from conf.protocol.address import Address
from conf.relay.router import Router, RouterOptions
from conf.relay.stun_responder import StunResponder
from conf.transport.relay_probe import NatKind, classify_nat, explain_refusal, probe_links, probe_nat
from conf.transport.relay_settings import Credentials
from tests.support.relay import LOOPBACK, free_port, router, running_responder

ONE: Address = ("192.0.2.1", 7448)
TWO: Address = ("192.0.2.1", 7449)
OUT, OTHER_PORT, OTHER_HOST = ("198.51.100.7", 4000), ("198.51.100.7", 4001), ("198.51.100.8", 4000)


@pytest.mark.parametrize(
    ("mapped", "kind"),
    [
        ({}, NatKind.BLOCKED),
        ({ONE: OUT}, NatKind.UNKNOWN),
        ({TWO: OUT}, NatKind.UNKNOWN),
        ({ONE: OUT, TWO: OUT}, NatKind.ONE_PORT),
        ({ONE: OUT, TWO: OTHER_PORT}, NatKind.SYMMETRIC),
        ({ONE: OUT, TWO: OTHER_HOST}, NatKind.SYMMETRIC),
        ({ONE: ("10.0.0.2", 5005), TWO: ("10.0.0.2", 5005)}, NatKind.NONE),
        ({ONE: ("10.0.0.2", 5005)}, NatKind.NONE),
        ({ONE: ("10.0.0.2", 5006), TWO: ("10.0.0.2", 5006)}, NatKind.ONE_PORT),
    ],
)
def test_kinds_of_nats(mapped: dict[Address, tuple[str, int]], kind: NatKind) -> None:
    report = classify_nat(mapped, [ONE, TWO], {"10.0.0.2"}, 5005)
    assert report.kind is kind
    assert report.outside == [mapped[server] for server in (ONE, TWO) if server in mapped]


@pytest.mark.slow
def test_this_machine_has_no_nat_to_itself() -> None:
    with running_responder() as relay:
        report = probe_nat(relay)
    assert report.kind is NatKind.NONE and {host for host, _ in report.outside} == {LOOPBACK}


@pytest.mark.slow
def test_a_responder_that_does_not_answer() -> None:
    for _ in range(20):
        port = free_port() - 1
        with StunResponder.bind(LOOPBACK, port):  # nobody steps it
            assert probe_nat((LOOPBACK, port)).kind is NatKind.BLOCKED
            return


@pytest.mark.slow
@pytest.mark.parametrize("kinds", ["tcp udp", "tcp", "udp"])
def test_links_to_a_relay(kinds: str) -> None:
    port = free_port()
    with router(port, kinds):
        assert probe_links((LOOPBACK, port)) == set(kinds.split())


@pytest.mark.slow
def test_no_links_without_a_relay_or_a_password(tmp_path: Path) -> None:
    port, password = free_port(), tmp_path / "password"
    assert probe_links((LOOPBACK, port)) == set()
    password.write_text("alice:secret\n")
    with Router(RouterOptions((LOOPBACK, port), (), password)):
        assert probe_links((LOOPBACK, port)) == set()
        assert probe_links((LOOPBACK, port), Credentials("alice", "secret")) == {"tcp", "udp"}


def test_a_relay_that_refuses_is_told_from_one_that_is_absent() -> None:
    port = free_port()
    absent = explain_refusal((LOOPBACK, port))
    with socket.create_server((LOOPBACK, port)):
        refusing = explain_refusal((LOOPBACK, port))
    assert f"the relay {LOOPBACK}:{port} does not answer: check its name and port" in absent
    assert f"the relay {LOOPBACK}:{port} answers but opens no session: check the user and password" in refusing
    assert explain_refusal(("no-such-host.invalid", 7447)).startswith("the relay no-such-host.invalid:7447 does not")
