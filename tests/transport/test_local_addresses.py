"""Which addresses of this machine are shown to callers."""

import ipaddress
import socket
from typing import Any

import pytest

from conf.transport.local_addresses import find_local_addresses, is_port_free, usable_addresses
from conf.transport.udp import UdpSocket


def test_addresses_that_no_other_machine_can_use_are_left_out() -> None:
    found = ["192.168.1.7", "127.0.1.1", "::1", "fe80::1%eth0", "0.0.0.0", "192.168.1.7", "2001:db8::7%2", "224.0.0.1"]
    assert usable_addresses(found) == ("192.168.1.7", "2001:db8::7")


def test_this_machine_has_addresses_or_none() -> None:
    for text in find_local_addresses():
        assert not ipaddress.ip_address(text).is_loopback


def test_a_machine_without_a_network_has_none(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: Any, **__: Any) -> Any:
        raise OSError("Network is unreachable")

    monkeypatch.setattr(socket.socket, "connect", fail)
    monkeypatch.setattr(socket, "getaddrinfo", fail)
    assert find_local_addresses() == ()


def test_the_address_of_the_default_route_comes_first(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(socket.socket, "connect", lambda handle, address: None)
    monkeypatch.setattr(socket.socket, "getsockname", lambda handle: ("10.0.0.2", 40000))
    other = (socket.AF_INET, socket.SOCK_DGRAM, 0, "", ("10.0.0.9", 0))
    monkeypatch.setattr(socket, "getaddrinfo", lambda *_, **__: [other])
    assert find_local_addresses() == ("10.0.0.2", "10.0.0.9")


def test_a_port_that_another_socket_has_is_not_free() -> None:
    with UdpSocket.bind("", 0) as taken:
        assert not is_port_free(taken.address[1])
    assert is_port_free(0)
