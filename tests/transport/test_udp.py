import errno
import socket
import sys
import time
from collections.abc import Iterator

import pytest

from conf.errors import NetworkError
from conf.protocol.address import Address
from conf.transport.udp import MAX_QUEUED_S, UdpSocket, resolve

LOOPBACK = "127.0.0.1"


@pytest.fixture
def peer() -> Iterator[socket.socket]:
    """A plain socket at the other end."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as made:
        made.bind((LOOPBACK, 0))
        made.settimeout(5)
        yield made


def test_a_listening_socket_receives_with_the_source_address_and_replies(peer: socket.socket) -> None:
    with UdpSocket.bind(LOOPBACK, 0) as receiver:
        assert receiver.remote is None
        for data in (b"one", b"", b"three"):
            peer.sendto(data, receiver.address)
        receiver.wait(5)
        received = receiver.receive()
        assert [one[:2] for one in received] == [(data, peer.getsockname()) for data in (b"one", b"", b"three")]
        assert receiver.receive() == []
        receiver.send([(b"reply", peer.getsockname())])
        assert peer.recv(100) == b"reply"


def test_a_socket_opened_to_a_peer_sends_and_receives(peer: socket.socket) -> None:
    with UdpSocket.open_to(*peer.getsockname()) as sender:
        assert sender.remote is not None and sender.remote == peer.getsockname()
        sender.send([(b"one", sender.remote), (b"two", sender.remote)])
        (first, address), (second, _) = peer.recvfrom(100), peer.recvfrom(100)
        assert [first, second] == [b"one", b"two"]
        for data in (b"", b"reply"):
            peer.sendto(data, address)
        sender.wait(5)
        received = sender.receive()
        assert [datagram[:2] for datagram in received] == [(b"", peer.getsockname()), (b"reply", peer.getsockname())]
        assert all(0 <= datagram.queued_s < 1 for datagram in received) and sender.receive() == []


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="other systems do not tell when a datagram arrived")
def test_a_datagram_carries_its_time_in_the_queue(peer: socket.socket, monkeypatch: pytest.MonkeyPatch) -> None:
    with UdpSocket.bind(LOOPBACK, 0) as receiver:
        for _ in range(50):  # the kernel begins to note times a little after it was asked to
            before = time.monotonic()
            peer.sendto(b"early", receiver.address)
            receiver.wait(5)
            sent = time.monotonic()
            while time.monotonic() < sent + 0.02:
                receiver.wait(0.001)
            (datagram,) = receiver.receive()
            if datagram.queued_s >= 0.02:
                break
        assert 0.02 <= datagram.queued_s <= time.monotonic() - before
        for offset, queued in [(0.5, pytest.approx(0.5, abs=0.2)), (2 * MAX_QUEUED_S, 0.0), (-5.0, 0.0)]:
            peer.sendto(b"x", receiver.address)
            receiver.wait(5)
            wall_clock = time.clock_gettime(time.CLOCK_REALTIME) + offset
            with monkeypatch.context() as patch:
                patch.setattr("conf.transport.udp.time.clock_gettime", lambda _, wall_clock=wall_clock: wall_clock)
                assert receiver.receive()[0].queued_s == queued


def test_no_more_than_the_limit_is_received_at_once(peer: socket.socket) -> None:
    with UdpSocket.bind(LOOPBACK, 0) as receiver:
        for i in range(5):
            peer.sendto(bytes([i]), receiver.address)
        receiver.wait(5)
        assert [len(receiver.receive(limit=2)) for _ in range(3)] == [2, 2, 1]


def test_wait_returns_after_its_time() -> None:
    with UdpSocket.bind(LOOPBACK, 0) as receiver:
        began = time.monotonic()
        receiver.wait(0.05)
        receiver.wait(-1.0)
        assert 0.04 < time.monotonic() - began < 2.0


def test_a_peer_whose_port_is_closed_is_no_error(peer: socket.socket) -> None:
    with UdpSocket.open_to(*peer.getsockname()) as sender:
        peer.close()
        for _ in range(3):
            sender.send([(b"anybody?", sender.remote or ("", 0))])
            sender.wait(0.01)
            assert sender.receive() == []


def test_a_datagram_too_large_for_the_network_is_lost(peer: socket.socket) -> None:
    with UdpSocket.bind(LOOPBACK, 0) as receiver:
        receiver.send([(b"x" * 70_000, peer.getsockname()), (b"small", peer.getsockname())])
        assert peer.recv(100) == b"small"


def test_a_port_in_use_is_named() -> None:
    with UdpSocket.bind(LOOPBACK, 0) as first:
        port = first.address[1]
        with pytest.raises(
            NetworkError, match=rf"cannot listen on 127\.0\.0\.1:{port} .*: choose another with --listen"
        ):
            UdpSocket.bind(LOOPBACK, port)


@pytest.mark.parametrize("host", ["no.such.host.invalid", "203.0.113.7", "x" * 300])
def test_an_address_of_another_machine_is_named(host: str) -> None:
    with pytest.raises(NetworkError, match="cannot listen on"):
        UdpSocket.bind(host, 0)


def test_a_name_without_an_address_is_named() -> None:
    sentence = "no address for 'no.such.host.invalid': give the receiver's name or number as HOST:PORT"
    with pytest.raises(NetworkError, match=sentence):
        UdpSocket.open_to("no.such.host.invalid", 5005)


class Failing:
    """A socket that cannot send to some addresses."""

    family = socket.AF_INET

    def __init__(self, error: OSError, but: tuple[str, int] | None = None) -> None:
        self.error, self.but, self.sent = error, but, list[bytes]()

    def sendto(self, data: bytes, address: object) -> int:
        if address != self.but:
            raise self.error
        self.sent.append(data)
        return len(data)

    def setblocking(self, flag: bool) -> None:
        pass


@pytest.mark.parametrize(
    ("error", "text"),
    [
        (
            PermissionError(1, "Operation not permitted"),
            r"this machine may not send to 127\.0\.0\.1:9: check its firewall",
        ),
        (
            OSError(101, "Network is unreachable"),
            r"nothing can be sent to 127\.0\.0\.1:9 \(Network is unreachable\): check",
        ),
        (OSError(105, "No buffer space available"), r"\(No buffer space available\): check this machine's network"),
        (OSError(100, "Network is down"), r"\(Network is down\): check this machine's network"),
        (OSError(113, "No route to host"), r"\(No route to host\): check this machine's network"),
        (OSError(90, "Message too long"), r"\(Message too long\): check this machine's network"),
        (
            PermissionError(errno.EACCES, "Permission denied"),
            r"127\.0\.0\.1:9 stands for many machines, or a firewall forbids it: give the address of one",
        ),
    ],
)
def test_what_keeps_datagrams_from_the_peer_is_named(error: OSError, text: str) -> None:
    sender = UdpSocket([Failing(error)], [(LOOPBACK, 9)])  # type: ignore[list-item]
    sender.send([(b"x", (LOOPBACK, 10))])  # to anybody else: lost
    with pytest.raises(NetworkError, match=text):
        sender.send([(b"x", (LOOPBACK, 9)), (b"y", (LOOPBACK, 9))])


def test_a_listening_socket_that_can_answer_nobody_says_so() -> None:
    handle = Failing(PermissionError(1, "Operation not permitted"), but=(LOOPBACK, 10))
    receiver = UdpSocket([handle])  # type: ignore[list-item]
    receiver.send([])
    receiver.send([(b"x", (LOOPBACK, 9)), (b"y", (LOOPBACK, 10))])  # one of two callers is reached
    with pytest.raises(NetworkError, match=r"this machine may not send to 127\.0\.0\.1:9: check its firewall"):
        receiver.send([(b"x", (LOOPBACK, 9))])
    assert handle.sent == [b"y"]


class FailingToReceive(Failing):
    """A socket that raises errors in turn, then has nothing more."""

    def __init__(self, *errors: OSError) -> None:
        super().__init__(errors[0])
        self.errors = [*errors]

    def recvmsg(self, size: int, control: int) -> object:
        raise self.errors.pop(0) if self.errors else BlockingIOError

    recvfrom = recvmsg


def test_a_machine_that_cannot_receive_says_so_and_junk_is_no_such_error() -> None:
    down = UdpSocket([FailingToReceive(OSError(100, "Network is down"))])  # type: ignore[list-item]
    with pytest.raises(
        NetworkError, match=r"nothing can be received \(Network is down\): check this machine's network"
    ):
        down.receive()
    assert down.receive() == []
    junk = [ConnectionResetError(), OSError(errno.EMSGSIZE, "too long")]
    assert UdpSocket([FailingToReceive(*junk)]).receive() == []  # type: ignore[list-item]


def test_one_address_that_works_is_enough() -> None:
    handle = Failing(OSError(101, "Network is unreachable"), but=(LOOPBACK, 10))
    sender = UdpSocket([handle], [(LOOPBACK, 9), (LOOPBACK, 10)])  # type: ignore[list-item]
    sender.send([(b"x", (LOOPBACK, 9))])
    assert handle.sent == [b"x"]


def two_addresses(*addresses: tuple[str, int]) -> object:
    return lambda *_, **__: [(socket.AF_INET, socket.SOCK_DGRAM, 17, "", address) for address in addresses]


def test_all_addresses_of_a_name_are_tried_until_one_answers(
    peer: socket.socket, monkeypatch: pytest.MonkeyPatch
) -> None:
    address = peer.getsockname()
    monkeypatch.setattr(socket, "getaddrinfo", two_addresses(("127.0.0.9", address[1]), address))
    with UdpSocket.open_to("name", address[1]) as sender:
        remote: Address = ("127.0.0.9", address[1])
        assert sender.remote == remote
        sender.send([(b"hello", remote)])
        data, source = peer.recvfrom(100)
        peer.sendto(b"reply", source)
        sender.wait(5)
        assert data == b"hello" and sender.receive()[0][:2] == (b"reply", remote)
        sender.send([(b"more", remote)])
        assert peer.recv(100) == b"more"


@pytest.mark.skipif(not socket.has_ipv6, reason="no IPv6 here")
def test_a_port_alone_listens_on_ipv4_and_ipv6() -> None:
    with UdpSocket.bind("", 0) as receiver:
        port = receiver.address[1]
        for host in (LOOPBACK, "::1"):
            with UdpSocket.open_to(host, port) as sender:
                assert sender.remote is not None
                sender.send([(host.encode(), sender.remote)])
                receiver.wait(5)
                (received,) = receiver.receive()
                receiver.send([(b"reply", received.address)])
                sender.wait(5)
                assert received.data == host.encode() and sender.receive()[0].data == b"reply"


@pytest.mark.parametrize("host", ["255.255.255.255", "224.0.0.1", "ff02::1"])
def test_nobody_can_listen_for_many_machines(host: str) -> None:
    with pytest.raises(NetworkError, match=f"{host} stands for many machines: give a port alone to listen on all"):
        UdpSocket.bind(host, 0)


@pytest.mark.parametrize("host", ["255.255.255.255", "224.0.0.1", "ff02::1", "ff02::1%lo", "::ffff:224.0.0.1"])
def test_an_address_of_many_machines_is_refused(host: str) -> None:
    with pytest.raises(NetworkError, match=f"{host} stands for many machines: give the address of one"):
        UdpSocket.open_to(host, 5005)


def test_a_name_with_many_addresses_is_tried_at_the_first_eight(monkeypatch: pytest.MonkeyPatch) -> None:
    addresses = [(f"127.0.0.{i}", 9) for i in range(1, 100)]
    monkeypatch.setattr(socket, "getaddrinfo", two_addresses(*addresses, *addresses))
    with UdpSocket.open_to("name", 9) as sender:
        assert (sender.remote, sender._candidates) == (addresses[0], addresses[:8])


def test_a_machine_without_ipv6_uses_the_ipv4_addresses_of_a_name(monkeypatch: pytest.MonkeyPatch) -> None:
    found = [
        (socket.AF_INET6, socket.SOCK_DGRAM, 17, "", ("::1", 9, 0, 0)),
        (socket.AF_INET, socket.SOCK_DGRAM, 17, "", (LOOPBACK, 9)),
    ]
    monkeypatch.setattr(socket, "getaddrinfo", lambda *_, **__: found)
    make = socket.socket

    def without_ipv6(family: int = -1, kind: int = -1, protocol: int = 0) -> socket.socket:
        if family == socket.AF_INET6:
            raise OSError(97, "Address family not supported by protocol")
        return make(family, kind, protocol)

    monkeypatch.setattr(socket, "socket", without_ipv6)
    with UdpSocket.open_to("name", 9) as sender:
        assert sender.remote == (LOOPBACK, 9)
    del found[1]
    with pytest.raises(
        NetworkError, match=r"\[::1\]:9 \(Address family not supported by protocol\): check this machine's"
    ):
        UdpSocket.open_to("name", 9)


@pytest.mark.skipif(not socket.has_ipv6, reason="no IPv6 here")
def test_a_link_local_address_keeps_its_zone() -> None:
    zone = socket.if_nameindex()[0]
    with UdpSocket.open_to(f"fe80::1%{zone[1]}", 5005) as sender:
        assert sender.remote == ("fe80::1", 5005, 0, zone[0])
    with pytest.raises(NetworkError, match="no address for 'fe80::1%nosuch'"):
        UdpSocket.open_to("fe80::1%nosuch", 5005)


def test_a_receive_buffer_that_the_system_refuses_is_no_error(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("conf.transport.udp.socket.SO_RCVBUF", 0x7777)  # no such option: OSError
    with UdpSocket.bind(LOOPBACK, 0) as receiver:
        assert receiver.address[0] == LOOPBACK


def test_a_name_is_resolved_to_addresses_as_sockets_report_them() -> None:
    assert resolve(LOOPBACK, 7448) == [(LOOPBACK, 7448)]
    with pytest.raises(NetworkError, match=r"no address for 'no\.such\.host\.invalid': check the name"):
        resolve("no.such.host.invalid", 1)
