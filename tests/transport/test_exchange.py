from collections.abc import Sequence
from contextlib import AbstractContextManager

import pytest

from conf.errors import NetworkError
from conf.protocol.address import Address
from conf.transport.exchange import RECEIVE_BATCH, DatagramExchange
from conf.transport.interface import ReceivedDatagram

PEER: Address = ("10.0.0.7", 1)
STRANGER: Address = ("10.0.0.9", 2)


class FakeLock(AbstractContextManager[None]):
    """A lock that tells whether it is held."""

    is_held = False

    def __enter__(self) -> None:
        self.is_held = True

    def __exit__(self, *_: object) -> None:
        self.is_held = False


class FakeSocket:
    """A socket that may fail. arrived : what it returns next; sent : what was sent"""

    def __init__(self) -> None:
        self.arrived: list[ReceivedDatagram] = []
        self.sent: list[tuple[bytes, Address]] = []
        self.fails = False
        self.candidates: tuple[Address, ...] = ()
        self.renewed = 0

    def renew(self) -> None:
        self.renewed += 1

    def receive(self, limit: int) -> list[ReceivedDatagram]:
        if self.fails:
            raise NetworkError("nothing can be received")
        arrived, self.arrived = self.arrived[:limit], self.arrived[limit:]
        return arrived

    def send(self, datagrams: list[tuple[bytes, Address]]) -> None:
        if self.fails and datagrams:
            raise NetworkError("nothing can be sent")
        self.sent += datagrams


class FakeEndpoint:
    """An endpoint that answers nothing of its own. lock : must be held while it is used"""

    def __init__(self, lock: FakeLock | None = None) -> None:
        self.received: list[tuple[bytes, Address, float]] = []
        self.pending: list[tuple[bytes, Address]] = []
        self.candidates: list[Sequence[Address]] = []
        self.is_unheard = False
        self.lock = lock

    def receive_datagram(self, data: bytes, address: Address, now: float) -> None:
        assert self.lock is None or self.lock.is_held
        self.received.append((data, address, now))

    def set_candidates(self, addresses: Sequence[Address]) -> None:
        self.candidates.append(addresses)

    def datagrams_to_send(self, now: float) -> list[tuple[bytes, Address]]:
        assert self.lock is None or self.lock.is_held
        pending, self.pending = self.pending, []
        return pending


class Stage:
    """A socket, an endpoint and the exchange between them."""

    def __init__(self, *, peers: set[Address] | None = None, lock: FakeLock | None = None) -> None:
        self.socket, self.endpoint = FakeSocket(), FakeEndpoint(lock)
        self.peers = peers
        source = None if peers is None else lambda: self.peers or set()
        self.exchange = DatagramExchange(self.socket, self.endpoint, peers=source, lock=lock)  # type: ignore[arg-type]

    def send(self, address: Address, now: float) -> None:
        self.endpoint.pending = [(b"x", address)]
        self.exchange.send(now)


def test_datagrams_have_the_time_of_their_arrival_and_the_lock_is_held() -> None:
    stage = Stage(lock=FakeLock())
    stage.socket.arrived = [ReceivedDatagram(b"a", PEER, 0.25), ReceivedDatagram(b"b", PEER, 0.0)]
    assert not stage.exchange.receive(10.0)
    assert stage.endpoint.received == [(b"a", PEER, 9.75), (b"b", PEER, 10.0)]
    stage.send(PEER, 10.0)
    assert stage.socket.sent == [(b"x", PEER)]


def test_the_way_to_the_relay_is_renewed_while_the_peer_hears_nothing() -> None:
    stage = Stage()
    stage.send(PEER, 10.0)
    assert not stage.socket.renewed
    stage.endpoint.is_unheard = True
    stage.send(PEER, 10.1)
    assert stage.socket.renewed == 1


def test_a_full_batch_is_told() -> None:
    stage = Stage()
    stage.socket.arrived = [ReceivedDatagram(b"junk", PEER, 0.0)] * (RECEIVE_BATCH + 1)
    assert [stage.exchange.receive(float(i)) for i in range(3)] == [True, False, False]


def test_a_calling_socket_that_never_worked_fails_at_once() -> None:
    stage = Stage()
    stage.socket.fails = True
    with pytest.raises(NetworkError, match="nothing can be received"):
        stage.exchange.receive(0.0)
    with pytest.raises(NetworkError, match="nothing can be sent"):
        stage.send(PEER, 0.0)


@pytest.mark.parametrize("peers", [None, {PEER}])
def test_a_failure_that_passes_is_noted_and_one_that_lasts_is_raised(peers: set[Address] | None) -> None:
    stage = Stage(peers=peers)
    stage.exchange.receive(0.0)
    stage.send(PEER, 0.0)
    stage.socket.fails = True
    stage.send(PEER, 1.0)
    assert stage.exchange.note == "nothing can be sent (trying for 10 s more)"
    stage.socket.fails = False
    stage.send(PEER, 2.0)
    assert stage.exchange.note == ""
    stage.socket.fails = True
    stage.exchange.receive(3.0)
    assert stage.exchange.note == "nothing can be received (trying for 10 s more)"
    stage.send(PEER, 3.0)
    with pytest.raises(NetworkError, match="nothing can be sent"):
        stage.send(PEER, 13.0)


def test_what_cannot_be_sent_to_a_stranger_ends_nothing() -> None:
    stage = Stage(peers={PEER})
    stage.socket.fails = True
    for now in range(30):
        stage.send(STRANGER, float(now))
    assert stage.exchange.note == "" and stage.exchange.pop_refused() == "nothing can be sent"
    assert stage.exchange.pop_refused() == ""


def test_a_note_ends_with_the_call() -> None:
    stage = Stage(peers={PEER})
    stage.socket.fails = True
    stage.send(PEER, 1.0)
    stage.socket.fails, stage.peers = False, set()
    stage.exchange.send(2.0)
    assert stage.exchange.note == ""


def test_candidate_addresses_are_handed_on_when_they_change() -> None:
    stage = Stage()
    stage.exchange.send(0.0)
    stage.socket.candidates = (PEER,)
    for _ in range(3):
        stage.exchange.send(0.0)
    assert stage.endpoint.candidates == [(PEER,)]
