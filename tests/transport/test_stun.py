import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.protocol.address import Address
from conf.transport.stun import (
    MAX_REQUESTS,
    StunClient,
    decode_request,
    decode_response,
    encode_request,
    encode_response,
)
from tests.support.simulated_sessions import seeded

# RFC 5769, 2.2 and 2.3: the header and XOR-MAPPED-ADDRESS of the sample responses, with the length of that alone.
TRANSACTION = bytes.fromhex("b7e7a701bc34d686fa87dfae")
RFC_IPV4 = bytes.fromhex("0101000c2112a442b7e7a701bc34d686fa87dfae002000080001a147e112a643")
RFC_IPV6 = bytes.fromhex("010100182112a442b7e7a701bc34d686fa87dfae002000140002a1470113a9faa5d3f179bc25f4b5bed2b9d9")
SERVER: Address = ("192.0.2.1", 7448)
OTHER: Address = ("192.0.2.1", 7449)


@pytest.mark.parametrize(
    ("data", "address"), [(RFC_IPV4, ("192.0.2.1", 32853)), (RFC_IPV6, ("2001:db8:1234:5678:11:2233:4455:6677", 32853))]
)
def test_the_examples_of_the_rfc(data: bytes, address: tuple[str, int]) -> None:
    assert decode_response(data) == (TRANSACTION, address)
    assert encode_response(TRANSACTION, address) == data


@given(st.binary(min_size=12, max_size=12), st.ip_addresses().map(str), st.integers(0, 65535))
def test_what_is_encoded_is_decoded_again(transaction: bytes, host: str, port: int) -> None:
    assert decode_request(encode_request(transaction)) == transaction
    assert decode_response(encode_response(transaction, (host, port))) == (transaction, (host, port))


@given(st.binary(max_size=80) | st.binary(max_size=40).map(lambda tail: RFC_IPV4[:20] + tail))
def test_any_bytes_are_a_message_or_none(data: bytes) -> None:
    request, response = decode_request(data), decode_response(data)
    assert request is None or response is None


@given(st.binary(max_size=60), st.integers(0, 65535))
def test_attributes_of_any_kind_and_length(value: bytes, length: int) -> None:
    attributes = b"\x00\x20" + length.to_bytes(2, "big") + value + bytes(-len(value) % 4)
    data = b"\x01\x01" + len(attributes).to_bytes(2, "big") + RFC_IPV4[4:20] + attributes
    answer = decode_response(data)
    assert answer is None or (length, len(value)) in {(8, n) for n in range(8, 61)} | {(20, n) for n in range(20, 61)}


def test_other_attributes_are_skipped() -> None:
    software = bytes.fromhex("802200057465737431000000")  # SOFTWARE, 5 bytes and padding
    data = b"\x01\x01\x00\x18" + RFC_IPV4[4:20] + software + RFC_IPV4[20:]
    assert decode_response(data) == (TRANSACTION, ("192.0.2.1", 32853))


@pytest.mark.parametrize("at", range(0, 8))
def test_a_changed_header_is_no_message(at: int) -> None:
    changed = bytearray(RFC_IPV4)
    changed[at] ^= 0x40
    assert decode_response(bytes(changed)) is None


def test_a_client_repeats_until_it_is_answered() -> None:
    client = StunClient([SERVER], seeded(1))
    ((first, address),) = client.datagrams_to_send(0.0)
    assert address == SERVER
    assert client.datagrams_to_send(0.1) == []
    assert client.datagrams_to_send(0.21) == [(first, SERVER)]
    answer = encode_response(first[8:], ("198.51.100.7", 4000))
    assert not client.receive_datagram(answer, OTHER)  # not from whom was asked
    assert not client.receive_datagram(encode_response(b"x" * 12, ("198.51.100.7", 4000)), SERVER)
    assert not client.receive_datagram(b"\x94 a call's", SERVER)
    assert client.outside_address is None and not client.is_done
    assert client.receive_datagram(answer, SERVER)
    assert client.receive_datagram(encode_response(first[8:], ("203.0.113.1", 1)), SERVER)  # too late to change it
    assert client.outside_address == ("198.51.100.7", 4000)
    assert client.is_done and client.datagrams_to_send(100.0) == []


def test_a_client_gives_up() -> None:
    client = StunClient([SERVER, OTHER], seeded(2))
    sent = [pair for step in range(1000) for pair in client.datagrams_to_send(step * 0.05)]
    assert [sum(address == server for _, address in sent) for server in (SERVER, OTHER)] == [MAX_REQUESTS] * 2
    assert client.is_done and client.outside_address is None
    assert len({data for data, _ in sent}) == 2
