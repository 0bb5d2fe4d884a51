"""Announced addresses: exact bytes, limits, and which of them are worth a probe."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.errors import ProtocolError
from conf.protocol.address import RelayAddress, SocketAddress
from conf.protocol.session.paths.candidates import (
    MAX_CANDIDATES,
    MAX_REVISION,
    PathCandidates,
    decode_candidates,
    encode_candidates,
    has_loopback,
    is_usable,
    usable_candidates,
)

PORTS = st.integers(0, 65535)
V4 = st.tuples(st.ip_addresses(v=4).map(str), PORTS)
V6 = st.tuples(st.ip_addresses(v=6).map(str), PORTS, st.just(0), st.just(0))
GOOD: list[SocketAddress] = [
    ("198.51.100.7", 40000),
    ("10.1.0.2", 1024),
    ("100.64.0.9", 65535),
    ("fd00::7", 40000, 0, 0),
]


@given(st.integers(1, MAX_REVISION), st.integers(0, MAX_REVISION), st.booleans(), st.lists(V4 | V6, max_size=8))
def test_what_is_encoded_is_decoded(revision: int, seen: int, wanted: bool, addresses: list[SocketAddress]) -> None:
    data = encode_candidates(PathCandidates(revision, seen, wanted, tuple(addresses)))
    ordered = sorted(addresses, key=len)
    assert decode_candidates(data) == PathCandidates(revision, seen, wanted, tuple(ordered))


@given(st.binary(max_size=200))
def test_any_bytes_decode_to_themselves_or_are_rejected(data: bytes) -> None:
    try:
        candidates = decode_candidates(data)
    except ProtocolError:
        return
    assert len(candidates.addresses) <= MAX_CANDIDATES and encode_candidates(candidates) == data


@pytest.mark.parametrize("address", GOOD)
def test_addresses_of_one_machine_are_usable(address: SocketAddress) -> None:
    assert is_usable(address, loopback=False)


@pytest.mark.parametrize(
    "host",
    "224.0.0.1 255.255.255.255 240.0.0.1 0.0.0.0 0.1.2.3 169.254.1.1 127.0.0.1 "
    "ff02::1 fe80::1 :: ::1 ::ffff:192.0.2.1 x".split(),
)
def test_addresses_of_many_or_of_nobody_are_not(host: str) -> None:
    assert not is_usable((host, 40000, 0, 0) if ":" in host else (host, 40000), loopback=False)


def test_ports_of_system_services_are_not() -> None:
    assert not is_usable(("198.51.100.7", 1023), loopback=False) and not is_usable(("127.0.0.1", 53), loopback=True)


def test_loopback_is_usable_where_this_machine_announces_it() -> None:
    assert is_usable(("127.0.0.1", 40000), loopback=True) and is_usable(("::1", 40000, 0, 0), loopback=True)
    assert has_loopback([*GOOD, ("127.0.0.2", 1)]) and not has_loopback(GOOD)


def test_few_different_addresses_are_kept() -> None:
    many: list[SocketAddress] = [("198.51.100.7", 40000 + n) for n in range(20)]
    assert usable_candidates([RelayAddress("4711", "x"), many[0], *many, ("224.0.0.1", 5000)], loopback=False) == tuple(
        many[:MAX_CANDIDATES]
    )
