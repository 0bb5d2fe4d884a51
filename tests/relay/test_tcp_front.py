import socket
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from conf.relay.flow_limits import PENDING_S, SENT_AT_ONCE, SENT_PER_S
from conf.relay.tcp_front import TcpFront
from tests.support.fake_router import LOOPBACK, TIMEOUT_S, FakeRouter

OPEN_ACK = b"\x02\0\x22x"
INIT_SYN = b"\x03\0\x01ab"

pytestmark = pytest.mark.slow


class Stage:
    """A front, and a member that is connected. link : of the router with the member"""

    def __init__(self, router: FakeRouter, front: TcpFront, port: int, *, is_accepted: bool) -> None:
        self.router, self.front, self.port = router, front, port
        self.member = socket.create_connection((LOOPBACK, port), TIMEOUT_S)
        router.carry()
        self.link = router.accept()
        if is_accepted:
            self.link.sendall(OPEN_ACK)
            assert self.read(self.member, len(OPEN_ACK)) == OPEN_ACK

    def read(self, handle: socket.socket, size: int) -> bytes:
        """Return bytes that arrive, while the front carries them."""
        data = b""
        while len(data) < size:
            self.router.carry(0.01)
            data += handle.recv(size - len(data))
        return data


@contextmanager
def stage(max_flows: int = 100, *, is_accepted: bool = True) -> Iterator[Stage]:
    with FakeRouter() as router, socket.create_server((LOOPBACK, 0)) as listener:
        front = TcpFront([listener], router.address, router.selector, max_flows=max_flows)
        made = Stage(router, front, int(listener.getsockname()[1]), is_accepted=is_accepted)
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
        assert (made.front.paused, made.front.read_bytes) == (0, 19 + len(OPEN_ACK))


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


def test_a_pending_connection_may_send_what_opens_a_session_byte_by_byte() -> None:
    with stage(is_accepted=False) as made:
        for byte in INIT_SYN[:-1]:
            made.member.sendall(bytes((byte,)))
            made.router.carry(0.01)
        made.link.setblocking(False)
        with pytest.raises(BlockingIOError):
            made.link.recv(1)
        made.link.settimeout(TIMEOUT_S)
        made.member.sendall(INIT_SYN[-1:] + b"\x05")  # and a part of what comes later
        assert made.read(made.link, len(INIT_SYN)) == INIT_SYN
        made.link.sendall(OPEN_ACK)
        assert made.read(made.member, len(OPEN_ACK)) == OPEN_ACK
        made.member.sendall(b"\0later")
        assert made.read(made.link, 7) == b"\x05\0later" and made.front.strangers == 0


@pytest.mark.parametrize(
    "junk",
    [b"\0\0", b"\x02\0\x05x", OPEN_ACK, INIT_SYN * 9, b"\xff\xff\x01" + bytes(5000), b"GET / HTTP/1.1\r\n\r\n" * 2000],
)
def test_a_pending_connection_that_sends_anything_else_is_closed_and_counted(junk: bytes) -> None:
    with stage(is_accepted=False) as made:
        made.member.sendall(junk)
        made.router.carry(0.02)
        assert made.front.strangers == 1
        assert made.link.recv(len(INIT_SYN) * 9) == b""


@pytest.mark.parametrize("side", ["member", "link"])
def test_the_end_of_one_side_is_the_end_of_the_other(side: str) -> None:
    with stage() as made:
        here, there = (made.member, made.link) if side == "member" else (made.link, made.member)
        here.close()
        made.router.carry()
        assert there.recv(1) == b""


def test_only_so_many_connections_and_none_that_opens_no_session() -> None:
    with stage(max_flows=1, is_accepted=False) as made:
        with socket.create_connection((LOOPBACK, made.port), TIMEOUT_S) as second:
            made.router.carry()
            assert second.recv(1) == b"" and made.front.refused == 1
        made.front.expire(PENDING_S)
        made.link.sendall(b"\x02\0\x61x")
        assert made.read(made.member, 4)
        made.front.expire(PENDING_S + 0.1)
        assert made.member.recv(1) == b""
        assert made.front.refused == 2
    with stage() as made:
        made.front.expire(PENDING_S + 0.1)
        made.member.sendall(b"a")
        assert made.read(made.link, 1) == b"a"
