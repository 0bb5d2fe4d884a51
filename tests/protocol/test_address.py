import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.protocol.address import (
    Address,
    RelayAddress,
    format_address,
    host_of,
    parse_address,
    parse_listen_address,
    typed_address,
)


@pytest.mark.parametrize(
    ("address", "text"),
    [
        (("127.0.0.1", 5005), "127.0.0.1:5005"),
        (("::", 6001, 0, 0), "[::]:6001"),
        (("fe80::1%eth0", 1, 0, 2), "[fe80::1%eth0]:1"),
        (("", 5005), "0.0.0.0:5005"),
    ],
)
def test_addresses_are_written_as_they_are_typed(address: Address, text: str) -> None:
    assert format_address(address) == text


@given(st.ip_addresses().map(str) | st.from_regex(r"[a-z0-9.-]+", fullmatch=True), st.integers(1, 65535))
def test_what_is_written_is_read_again(host: str, port: int) -> None:
    assert parse_address(format_address((host, port))) == (host, port)
    assert parse_address(f"[{host}]") == (host, 5005)


@given(st.text())
def test_any_text_is_an_address_or_a_value_error(text: str) -> None:
    for parse in parse_address, parse_listen_address:
        try:
            host, port = parse(text)
        except ValueError as error:
            assert text in str(error)
        else:
            assert host in text and 0 <= port < 65536


def test_port_0_can_be_listened_on_but_not_called() -> None:
    assert parse_listen_address("0") == ("", 0)
    with pytest.raises(ValueError, match="h:0 names no port: give the one that the receiver shows"):
        parse_address("h:0")


def test_a_peer_behind_a_relay_has_no_host_of_its_own() -> None:
    first, second = RelayAddress("4711", "aaaa"), RelayAddress("4712", "bbbb")
    assert [format_address(first), format_address(RelayAddress("4711", ""))] == ["relay/aaaa", "relay"]
    assert host_of(first) == host_of(second) == "the relay"
    assert host_of(("::1", 5005, 0, 0)) == "::1"


@pytest.mark.parametrize(
    ("address", "port", "text"),
    [("10.0.0.7", 5005, "10.0.0.7"), ("10.0.0.7", 6001, "10.0.0.7:6001"), ("fd00::2", 5005, "fd00::2"),
     ("fd00::2", 6001, "[fd00::2]:6001")],
)  # fmt: skip
def test_addresses_are_shown_as_they_are_typed(address: str, port: int, text: str) -> None:
    assert typed_address(address, port) == text


@pytest.mark.parametrize("text", ["65536", ":99999"])
def test_a_number_that_is_no_port_is_not_a_host_to_listen_at(text: str) -> None:
    assert parse_listen_address("65535") == ("", 65535)
    with pytest.raises(ValueError, match=f"^{text} is no port: give one up to 65535$"):
        parse_listen_address(text)


@pytest.mark.parametrize("text", [":::", "[1:2]:5005", "a:b:c", "fe80::1::2"])
def test_what_has_colons_is_an_ipv6_address(text: str) -> None:
    assert parse_address("[fe80::1%eth0]:6001") == ("fe80::1%eth0", 6001)
    with pytest.raises(ValueError, match=r"is neither HOST:PORT nor an IPv6 address$"):
        parse_address(text)
