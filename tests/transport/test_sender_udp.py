import socket
from collections.abc import Iterator

import pytest

from conf.errors import NetworkError
from conf.transport.sender_udp import UdpSocket

LOOPBACK = "127.0.0.1"


@pytest.fixture
def other() -> Iterator[socket.socket]:
    """A socket at the other end."""
    made = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    made.bind((LOOPBACK, 0))
    made.settimeout(5)
    yield made
    made.close()


def test_there_and_back(other: socket.socket) -> None:
    with UdpSocket(*other.getsockname()) as sender:
        assert sender.remote == other.getsockname()
        sender.send([(b"one", sender.remote), (b"two", sender.remote)])
        (first, address), (second, _) = other.recvfrom(100), other.recvfrom(100)
        assert [first, second] == [b"one", b"two"]
        for data in (b"", b"answer"):
            other.sendto(data, address)
        sender.wait(5)
        assert sender.receive() == [(b"", other.getsockname()), (b"answer", other.getsockname())]
        assert sender.receive() == []


def test_a_receiver_that_is_not_there_yet_is_no_error(other: socket.socket) -> None:
    with UdpSocket(*other.getsockname()) as sender:
        other.close()
        for _ in range(3):
            sender.send([(b"anybody?", sender.remote)])
            sender.wait(0.01)
            assert sender.receive() == []


def test_what_is_too_large_for_the_network_is_lost(other: socket.socket) -> None:
    with UdpSocket(*other.getsockname()) as sender:
        sender.send([(b"x" * 70_000, sender.remote), (b"small", sender.remote)])
        assert other.recv(100) == b"small"


def test_a_name_without_an_address_is_named() -> None:
    sentence = "no address for 'no.such.host.invalid': give the receiver's name or number as HOST:PORT"
    with pytest.raises(NetworkError, match=sentence):
        UdpSocket("no.such.host.invalid", 5005)


def test_a_firewall_that_forbids_sending_is_named(other: socket.socket, monkeypatch: pytest.MonkeyPatch) -> None:
    class Forbidden:
        def sendto(self, data: bytes, address: object) -> int:
            raise PermissionError(1, "Operation not permitted")

        def close(self) -> None:
            pass

    with UdpSocket(*other.getsockname()) as sender:
        sender._socket.close()
        monkeypatch.setattr(sender, "_socket", Forbidden())
        with pytest.raises(NetworkError, match=r"this machine may not send to 127\.0\.0\.1: check its firewall"):
            sender.send([(b"x", sender.remote)])
