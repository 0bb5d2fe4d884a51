from contextlib import AbstractContextManager

import pytest

from conf.errors import NetworkError
from conf.protocol.address import Address, RelayAddress
from conf.transport.combined import CombinedTransport
from conf.transport.interface import ReceivedDatagram
from conf.transport.stun import StunClient, encode_response
from conf.transport.wake_up import WakeUp
from tests.support.simulated_sessions import seeded

PEER: Address = ("10.0.0.7", 1)
SERVER: Address = ("192.0.2.1", 7448)
RELAY = RelayAddress("4711", "abc")


class FakeTransport:
    """A transport that may fail. arrived : what it returns next; sent : what was sent"""

    def __init__(self, remote: Address | None = None, address: Address = PEER) -> None:
        self.remote, self.address = remote, address
        self.handles = [WakeUp()]
        self.arrived: list[ReceivedDatagram] = []
        self.sent: list[tuple[bytes, Address]] = []
        self.fails = self.is_closed = self.is_renewed = False

    def renew(self) -> None:
        self.is_renewed = True

    def receive(self, limit: int) -> list[ReceivedDatagram]:
        if self.fails:
            raise NetworkError("nothing can be received")
        arrived, self.arrived = self.arrived[:limit], self.arrived[limit:]
        return arrived

    def send(self, datagrams: list[tuple[bytes, Address]]) -> None:
        if self.fails:
            raise NetworkError("nothing can be sent")
        self.sent += datagrams

    def close(self) -> None:
        self.is_closed = True
        for handle in self.handles:
            handle.close()


class Stage(AbstractContextManager["Stage"]):
    """Both ways and their combination, at a time that a test sets."""

    def __init__(self, stun: StunClient | None = None) -> None:
        self.now = 0.0
        self.udp, self.relay = FakeTransport(), FakeTransport(RelayAddress("4711", ""), RELAY)
        self.transport = CombinedTransport(self.udp, self.relay, stun=stun, clock=lambda: self.now)  # type: ignore[arg-type]

    def __exit__(self, *_: object) -> None:
        self.transport.close()


def test_each_datagram_goes_where_its_address_is() -> None:
    with Stage() as stage:
        stage.transport.send([(b"a", PEER), (b"b", RELAY), (b"c", PEER)])
        assert stage.udp.sent == [(b"a", PEER), (b"c", PEER)]
        assert stage.relay.sent == [(b"b", RELAY)]
        assert stage.transport.remote == RelayAddress("4711", "")
        assert stage.transport.address == PEER


def test_what_arrives_on_both_ways_is_received() -> None:
    with Stage() as stage:
        first, second = ReceivedDatagram(b"a", PEER, 0.1), ReceivedDatagram(b"b", RELAY, 0.2)
        stage.udp.arrived, stage.relay.arrived = [first], [second]
        assert stage.transport.receive(8) == [first, second]
        for way in stage.udp, stage.relay:
            way.handles[0].set()
            stage.transport.wait(10)  # returns at once
            way.handles[0].clear()


def test_one_way_that_fails_does_not_stop_the_other() -> None:
    with Stage() as stage:
        stage.relay.fails = True
        stage.transport.send([(b"a", PEER), (b"b", RELAY)])
        assert stage.udp.sent == [(b"a", PEER)]
        stage.udp.arrived = [ReceivedDatagram(b"a", PEER, 0.0)]
        assert len(stage.transport.receive(8)) == 1
        with pytest.raises(NetworkError, match="sent"):
            stage.transport.send([(b"b", RELAY)])
        stage.udp.fails = True
        with pytest.raises(NetworkError, match="received"):
            stage.transport.receive(8)
        stage.transport.send([])  # nothing to fail


def test_answers_of_stun_servers_reach_nobody_else() -> None:
    with Stage(StunClient([SERVER], seeded(1))) as stage:
        stage.transport.send([])
        ((request, address),) = stage.udp.sent
        assert address == SERVER and stage.relay.sent == []
        answer = encode_response(request[8:], ("198.51.100.7", 4000))
        stage.udp.arrived = [ReceivedDatagram(answer, SERVER, 0.0), ReceivedDatagram(b"a", SERVER, 0.0)]
        assert stage.transport.receive(8) == [ReceivedDatagram(b"a", SERVER, 0.0)]
        assert stage.transport.stun and stage.transport.stun.outside_address == ("198.51.100.7", 4000)


def test_a_stun_server_that_cannot_be_reached_is_no_failure() -> None:
    with Stage(StunClient([SERVER], seeded(1))) as stage:
        stage.udp.fails = True
        stage.transport.send([(b"b", RELAY)])
        assert stage.relay.sent == [(b"b", RELAY)]


def test_the_way_to_the_relay_is_renewed() -> None:
    with Stage() as stage:
        stage.transport.renew()
        assert stage.relay.is_renewed and not stage.udp.is_renewed


def test_both_ways_are_closed() -> None:
    with Stage() as stage:
        with stage.transport as transport:
            assert transport.handles == [*stage.udp.handles, *stage.relay.handles]
        assert stage.udp.is_closed and stage.relay.is_closed
