import struct

import pytest

from tools.network.own_network import Packet, parse_packet

UDP = struct.pack(">HHHH", 5000, 7447, 12, 0) + b"data"
TCP = struct.pack(">HHIIBBHHH", 7447, 5001, 1, 2, 8 << 4, 0x18, 100, 0, 0) + bytes(12) + b"more"


def ipv4(kind: int, body: bytes, options: bytes = b"") -> bytes:
    head = struct.pack(
        ">BBHHHBBHII", 0x45 + len(options) // 4, 0, 20 + len(options) + len(body), 0, 0, 64, kind, 0, 0, 0
    )
    return head + options + body


def test_packets_are_read_with_their_payload() -> None:
    assert parse_packet(ipv4(17, UDP)) == Packet("udp", 5000, 7447, 32, b"data")
    assert parse_packet(ipv4(17, UDP, bytes(4)) + b"padding") == Packet("udp", 5000, 7447, 36, b"data")
    assert parse_packet(ipv4(6, TCP)) == Packet("tcp", 7447, 5001, 56, b"more")


@pytest.mark.parametrize("data", [b"", bytes(40), ipv4(1, UDP), b"\x60" + bytes(60)])
def test_other_packets_are_none(data: bytes) -> None:
    assert parse_packet(data) is None
