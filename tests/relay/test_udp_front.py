import socket
import struct
from collections.abc import Iterator
from contextlib import contextmanager

import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.relay.flow_limits import IDLE_S, PENDING_S, SENT_AT_ONCE
from conf.relay.udp_front import MAX_TO_OPEN, Batches, UdpFront, connect_to_router
from conf.transport.udp import UdpSocket
from tests.support.fake_router import LOOPBACK, TIMEOUT_S, FakeRouter

INIT, INIT_ANSWER, OPEN, OPEN_ANSWER, FRAME = (bytes([first]) + b"x" for first in (0x41, 0x61, 0x42, 0x22, 0x25))
pytestmark = pytest.mark.slow


class Stage:
    """A front, and a member that has begun to open a session. link : of the router with the member"""

    def __init__(self, router: FakeRouter, front: UdpFront, port: int) -> None:
        self.router, self.front = router, front
        self.member = self.new_member(port)
        self.port = port
        self.arrived = 0  # bytes at the router
        self.send(INIT)
        self.link = router.accept()

    def new_member(self, port: int) -> socket.socket:
        member = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        member.settimeout(TIMEOUT_S)
        member.connect((LOOPBACK, port))
        return member

    def send(self, *datagrams: bytes) -> None:
        for data in datagrams:
            self.member.send(data)
        self.router.carry()

    def answer(self, *batches: bytes) -> list[bytes]:
        """Return what the member gets of what the router sends."""
        self.link.sendall(b"".join(struct.pack("<H", len(batch)) + batch for batch in batches))
        self.router.carry()
        return [self.member.recv(65_535) for _ in batches]

    def read(self, size: int) -> bytes:
        """Return bytes that arrive at the router."""
        data = b""
        while len(data) < size and (more := self.link.recv(size - len(data))):
            data += more
        self.arrived += len(data)
        return data


@contextmanager
def stage(max_flows: int = 100) -> Iterator[Stage]:
    with FakeRouter() as router:
        outer = UdpSocket.bind(LOOPBACK, 0)
        front = UdpFront(outer, router.address, router.selector, max_flows=max_flows)
        made = Stage(router, front, outer.address[1])
        try:
            yield made
        finally:
            front.close()
            made.member.close()
            made.link.close()


def test_batches_pass_both_ways() -> None:
    with stage() as made:
        assert made.read(4) == b"\x02\0" + INIT
        assert made.answer(INIT_ANSWER) == [INIT_ANSWER]
        made.send(OPEN)
        assert made.answer(OPEN_ANSWER, b"", FRAME * 1000) == [OPEN_ANSWER, b"", FRAME * 1000]
        made.send(FRAME)
        assert made.read(8) == b"\x02\0" + OPEN + b"\x02\0" + FRAME
        assert (made.front.forwarded, made.front.strangers, made.front.excess) == (3, 0, 0)


def test_a_stranger_is_counted_and_opens_nothing() -> None:
    with stage() as made, made.new_member(made.port) as stranger:
        for data in (b"", FRAME, OPEN, INIT_ANSWER, b"\0" * 1400):
            stranger.send(data)
        made.router.carry()
        assert (made.front.strangers, made.front.forwarded) == (5, 1)


def test_a_pending_flow_sends_nothing_but_what_opens_a_session() -> None:
    with stage() as made:
        made.send(FRAME, b"", *[INIT] * 20)
        assert made.front.forwarded == MAX_TO_OPEN - 2 and made.front.strangers == 22 - (MAX_TO_OPEN - 3)
        made.front.expire(PENDING_S)
        made.front.expire(PENDING_S + 0.1)
        made.send(FRAME)
        assert made.front.strangers == 23 - (MAX_TO_OPEN - 3)


def test_a_flood_of_a_member_is_cut_and_counted() -> None:
    with stage() as made:
        made.answer(OPEN_ANSWER)
        made.read(4)
        made.arrived = 0
        count = int(SENT_AT_ONCE / 1000) * 2
        for _ in range(count // 50):
            made.send(*[FRAME * 700] * 50)
            made.read((made.front.forwarded - 1) * 1402 - made.arrived)
        assert made.front.forwarded + made.front.excess == count + 1
        assert made.front.excess > count / 4


def test_a_session_that_ends_or_is_silent_is_forgotten() -> None:
    with stage() as made:
        made.answer(OPEN_ANSWER)
        made.front.expire(IDLE_S)
        made.send(FRAME)
        assert made.front.strangers == 0
        made.link.close()
        made.router.carry()
        made.send(FRAME)
        assert made.front.strangers == 1
    with stage() as made:
        made.answer(OPEN_ANSWER)
        made.front.expire(IDLE_S + 1)
        made.send(FRAME)
        assert made.front.strangers == 1 and made.read(10) == b"\x02\0" + INIT


def test_only_so_many_flows_are_admitted() -> None:
    with stage(max_flows=1) as made, made.new_member(made.port) as second:
        second.send(INIT)
        made.router.carry()
        assert (made.front.refused, made.front.strangers) == (1, 1)
        assert made.front.overflows == 0


def test_a_router_that_is_not_there() -> None:
    with FakeRouter() as router:
        address = router.address
    assert connect_to_router(address) is None


@given(st.lists(st.binary(max_size=300), max_size=20), st.integers(1, 50))
def test_batches_are_found_however_a_stream_is_cut(batches: list[bytes], size: int) -> None:
    stream = b"".join(struct.pack("<H", len(batch)) + batch for batch in batches)
    splitter, found = Batches(), list[bytes]()
    for start in range(0, len(stream), size):
        found += splitter.split(stream[start : start + size])
    assert found == batches
