import socket
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from conf.relay.flow_limits import PENDING_S, SENT_AT_ONCE, SENT_PER_S
from conf.relay.tcp_front import TcpFront
from tests.support.fake_router import LOOPBACK, TIMEOUT_S, FakeRouter

pytestmark = pytest.mark.slow


class Stage:
    """A front, and a member that is connected. link : of the router with the member"""

    def __init__(self, router: FakeRouter, front: TcpFront, port: int) -> None:
        self.router, self.front, self.port = router, front, port
        self.member = socket.create_connection((LOOPBACK, port), TIMEOUT_S)
        router.carry()
        self.link = router.accept()

    def read(self, handle: socket.socket, size: int) -> bytes:
        """Return bytes that arrive, while the front carries them."""
        data = b""
        while len(data) < size:
            self.router.carry(0.01)
            data += handle.recv(size - len(data))
        return data


@contextmanager
def stage(max_flows: int = 100) -> Iterator[Stage]:
    with FakeRouter() as router, socket.create_server((LOOPBACK, 0)) as listener:
        front = TcpFront([listener], router.address, router.selector, max_flows=max_flows)
        made = Stage(router, front, int(listener.getsockname()[1]))
        try:
            yield made
        finally:
            made.member.close()
            made.link.close()
            front.close()


def test_bytes_pass_both_ways() -> None:
    with stage() as made:
        made.member.sendall(b"to the router")
        assert made.read(made.link, 13) == b"to the router"
        made.link.sendall(b"answer")
        assert made.read(made.member, 6) == b"answer"
        assert (made.front.paused, made.front.read_bytes) == (0, 19)


def test_what_cannot_be_written_yet_waits_and_nothing_is_lost() -> None:
    with stage() as made:
        sent, data = 0, bytes(range(256)) * 64
        made.link.setblocking(False)
        for _ in range(2000):  # until the buffers of the system and of the front are full
            try:
                sent += made.link.send(data)
            except BlockingIOError:
                made.router.carry(0.0)
                made.router.now += 1.0
                made.front.resume(made.router.now)
                if sent > 4_000_000:
                    break
        received = b""
        while len(received) < sent:
            made.router.now += 1.0
            made.front.resume(made.router.now)
            received += made.read(made.member, min(50_000, sent - len(received)))
        assert received == (data * (sent // len(data) + 1))[:sent]


def test_a_flood_has_to_wait() -> None:
    with stage() as made:
        made.member.setblocking(False)
        sent = 0
        while sent < SENT_AT_ONCE * 1.5:
            try:
                sent += made.member.send(bytes(10_000))
            except BlockingIOError:
                break
        made.router.carry(0.02)
        assert made.front.paused >= 1 and made.front.is_waiting
        paused = made.front.paused
        made.front.resume(made.router.now)
        assert made.front.is_waiting
        made.router.now += 20_000 / SENT_PER_S
        made.front.resume(made.router.now)
        assert not made.front.is_waiting
        made.router.carry(0.02)
        assert made.front.paused > paused


@pytest.mark.parametrize("side", ["member", "link"])
def test_the_end_of_one_side_is_the_end_of_the_other(side: str) -> None:
    with stage() as made:
        here, there = (made.member, made.link) if side == "member" else (made.link, made.member)
        here.close()
        made.router.carry()
        assert there.recv(1) == b""


def test_only_so_many_connections_and_none_that_opens_no_session() -> None:
    with stage(max_flows=1) as made:
        with socket.create_connection((LOOPBACK, made.port), TIMEOUT_S) as second:
            made.router.carry()
            assert second.recv(1) == b"" and made.front.refused == 1
        made.front.expire(PENDING_S)
        made.link.sendall(b"\x02\0\x61x")
        assert made.read(made.member, 4)
        made.front.expire(PENDING_S + 0.1)
        assert made.member.recv(1) == b""
    with stage() as made:
        made.link.sendall(b"\x02\0\x22x")  # OpenAck
        assert made.read(made.member, 4)
        made.front.expire(PENDING_S + 0.1)
        made.member.sendall(b"a")
        assert made.read(made.link, 1) == b"a"
