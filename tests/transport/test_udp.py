import socket
import sys
import time

import pytest

from conf.errors import NetworkError
from conf.transport.udp import UdpSocket

LOOPBACK = "127.0.0.1"


def test_what_comes_is_taken_with_its_address_and_answered() -> None:
    with (
        UdpSocket(LOOPBACK, 0) as receiver,
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other,
    ):
        other.settimeout(5)
        other.bind((LOOPBACK, 0))
        for data in (b"one", b"", b"three"):
            other.sendto(data, receiver.address)
        receiver.wait(5)
        taken = receiver.receive()
        assert [one[:2] for one in taken] == [(data, other.getsockname()) for data in (b"one", b"", b"three")]
        assert receiver.receive() == []
        receiver.send([(b"answer", other.getsockname())])
        assert other.recv(100) == b"answer"


@pytest.mark.skipif(sys.platform != "linux", reason="other systems do not tell when a datagram came")
def test_a_datagram_tells_how_long_it_has_waited() -> None:
    with UdpSocket(LOOPBACK, 0) as receiver, socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
        for _ in range(50):  # the system begins to note times a moment after it was asked
            before = time.monotonic()
            other.sendto(b"early", receiver.address)
            receiver.wait(5)
            sent = time.monotonic()
            while time.monotonic() < sent + 0.02:
                receiver.wait(0.001)
            (arrival,) = receiver.receive()
            if arrival.queued_s >= 0.02:
                break
        assert 0.02 <= arrival.queued_s <= time.monotonic() - before


def test_no_more_than_the_limit_is_taken_at_once() -> None:
    with UdpSocket(LOOPBACK, 0) as receiver, socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
        for i in range(5):
            other.sendto(bytes([i]), receiver.address)
        receiver.wait(5)
        assert [len(receiver.receive(limit=2)) for _ in range(3)] == [2, 2, 1]


def test_it_waits_no_longer_than_it_is_told() -> None:
    with UdpSocket(LOOPBACK, 0) as receiver:
        began = time.monotonic()
        receiver.wait(0.05)
        receiver.wait(-1.0)
        assert 0.04 < time.monotonic() - began < 2.0


def test_answers_that_cannot_be_sent_are_lost_without_a_word() -> None:
    with UdpSocket(LOOPBACK, 0) as receiver:
        receiver.send([(b"x" * 70_000, (LOOPBACK, 9)), (b"nobody listens", (LOOPBACK, 9))])
        assert receiver.receive() == []


def test_a_port_that_is_taken_is_named() -> None:
    with UdpSocket(LOOPBACK, 0) as first:
        port = first.address[1]
        with pytest.raises(
            NetworkError, match=rf"cannot listen on 127\.0\.0\.1:{port} .*: choose another with --listen"
        ):
            UdpSocket(LOOPBACK, port)


@pytest.mark.parametrize("host", ["no.such.host.invalid", "203.0.113.7", "x" * 300])
def test_an_address_that_is_not_ours_is_named(host: str) -> None:
    with pytest.raises(NetworkError, match="cannot listen on"):
        UdpSocket(host, 0)
