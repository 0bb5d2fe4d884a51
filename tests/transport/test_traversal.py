"""A UDP socket beside a relay: its candidate addresses, and what a path is called."""

import pytest

from conf.errors import NetworkError
from conf.protocol.address import Address, RelayAddress
from conf.transport.interface import ReceivedDatagram
from conf.transport.stun import decode_request, encode_response
from conf.transport.traversal import CHECK_S, TraversalTransport, find_stun_servers
from tests.transport.test_combined import FakeTransport

SERVER = ("192.0.2.1", 7448)
OUTSIDE = ("203.0.113.5", 6000)


class FakeRelay(FakeTransport):
    """A relay that is reached over UDP or TCP."""

    carrier = "udp"

    def path_name(self, address: Address) -> str:
        return f"relay by {self.carrier}"


class Stage:
    """A transport at a time, and with addresses of the machine, that a test sets."""

    def __init__(self, server: Address = SERVER) -> None:
        self.now, self.hosts = 0.0, ["10.1.0.2", "2001:db8::2"]
        self.udp, self.relay = FakeTransport(address=("0.0.0.0", 40000)), FakeRelay(RelayAddress("4711", ""))
        self.transport = TraversalTransport(
            self.udp,  # type: ignore[arg-type]
            self.relay,  # type: ignore[arg-type]
            servers=[server],  # type: ignore[list-item]
            clock=lambda: self.now,
            find_addresses=lambda: self.hosts,
        )

    def answer(self, outside: tuple[str, int] = OUTSIDE) -> None:
        """Let the STUN server answer."""
        self.transport.receive(10)
        self.transport.send([])
        request, server = self.udp.sent[-1]
        transaction = decode_request(request)
        assert transaction
        self.udp.arrived = [ReceivedDatagram(encode_response(transaction, outside), server, 0.0)]
        assert self.transport.receive(10) == []


def test_candidates_are_the_outside_address_and_those_of_the_machine() -> None:
    stage = Stage()
    assert stage.transport.candidates == ()
    stage.answer()
    assert stage.transport.candidates == (OUTSIDE, ("10.1.0.2", 40000), ("2001:db8::2", 40000, 0, 0))
    assert stage.udp.sent[0][1] == SERVER
    stage.transport.close()


def test_in_another_network_there_are_other_candidates() -> None:
    stage = Stage()
    stage.answer()
    stage.hosts = ["10.9.0.2"]
    stage.now = CHECK_S - 0.1
    stage.transport.receive(10)
    assert OUTSIDE in stage.transport.candidates
    stage.now = CHECK_S
    stage.answer(("203.0.113.6", 7000))
    assert stage.transport.candidates == (("203.0.113.6", 7000), ("10.9.0.2", 40000))
    stage.transport.close()


def test_beside_a_relay_on_this_machine_loopback_is_a_candidate() -> None:
    stage = Stage(("127.0.0.1", 7448))
    stage.transport.receive(10)
    assert ("127.0.0.1", 40000) in stage.transport.candidates
    stage.transport.close()


def test_a_path_has_a_name() -> None:
    stage = Stage()
    assert stage.transport.path_name(("10.0.0.1", 5)) == "direct"
    assert stage.transport.path_name(RelayAddress("4711", "x")) == "relay by udp"
    stage.transport.close()


def test_the_stun_responder_is_beside_the_relay() -> None:
    assert find_stun_servers(None) == []
    assert find_stun_servers(("127.0.0.1", 7447)) == [("127.0.0.1", 7447 + 1)]
    with pytest.raises(NetworkError, match="no address for the relay 'no such host': check its name"):
        find_stun_servers(("no such host", 7447))
