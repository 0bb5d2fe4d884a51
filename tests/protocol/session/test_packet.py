"""Framing: one encoding for every datagram, msgpack as the oracle, and a counted error for all else."""

import msgpack
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from conf.protocol.session.drop_reasons import DatagramError, DropReason
from conf.protocol.session.packet import (
    FIELDS,
    MAX_COUNTER,
    MAX_DATAGRAM,
    SHORT_COUNTER_REACH,
    TAG_BYTES,
    VERSION,
    DataPacket,
    HandshakePacket,
    Kind,
    data_header,
    handshake_datagram,
    parse_datagram,
    restore_counter,
)

SEALED = st.binary(min_size=TAG_BYTES, max_size=1180)


def reason_of(data: bytes) -> DropReason | None:
    try:
        parse_datagram(data)
    except DatagramError as error:
        return error.reason
    return None


@pytest.mark.slow
@given(st.integers(0, 127), st.integers(0, MAX_COUNTER), SEALED)
def test_a_data_datagram_is_a_msgpack_array_and_parses_back(session: int, counter: int, sealed: bytes) -> None:
    header = data_header(session, counter, -1000, len(sealed) - TAG_BYTES)
    assert msgpack.unpackb(header + sealed) == [VERSION, session, counter, sealed]
    assert header + sealed == msgpack.packb([VERSION, session, counter, sealed])
    assert parse_datagram(header + sealed) == DataPacket(session, counter, header, sealed)


@pytest.mark.parametrize("kind", Kind)
def test_a_handshake_datagram_is_a_msgpack_array_and_parses_back(kind: Kind) -> None:
    fields = FIELDS[kind].unpack(bytes(range(FIELDS[kind].size)))
    data = handshake_datagram(kind, *fields)
    version, on_wire, body = msgpack.unpackb(data)
    assert (version, on_wire, body[:-4]) == (VERSION, kind, bytes(range(FIELDS[kind].size)))
    assert parse_datagram(data) == HandshakePacket(kind, fields)


def test_framing_and_seal_of_a_small_body_cost_14_bytes() -> None:
    for body_bytes in range(248):
        assert len(data_header(5, 1000, 960, body_bytes)) + TAG_BYTES == 14
    assert len(data_header(5, 1000, 960, 248)) + TAG_BYTES == 15


def test_a_counter_is_short_up_to_64_above_what_is_acknowledged() -> None:
    assert len(data_header(5, 1064, 1000, 0)) == 6
    assert len(data_header(5, 1065, 1000, 0)) == 8


@pytest.mark.slow
@given(st.integers(0, MAX_COUNTER - 200), st.integers(0, SHORT_COUNTER_REACH - 1), st.integers(0, SHORT_COUNTER_REACH))
@example(0, 0, 0)
@example(127, 0, 1)
def test_a_short_counter_is_restored_whatever_has_arrived_since(highest: int, ahead: int, behind: int) -> None:
    """The receiver has `highest`; the datagram is up to 64 ahead of it, or overtaken by at most 62 others."""
    counter = highest + 1 + ahead if ahead else max(0, highest - min(behind, SHORT_COUNTER_REACH - 2))
    acknowledged = min(highest, counter - 1)
    data = data_header(0, counter, acknowledged, 0) + bytes(TAG_BYTES)
    packet = parse_datagram(data)
    assert isinstance(packet, DataPacket)
    assert restore_counter(packet.counter, highest) == counter


@pytest.mark.slow
@given(st.integers(0, 127), st.integers(-1, 70))
def test_the_first_128_counters_need_no_acknowledgement(counter: int, highest: int) -> None:
    packet = parse_datagram(data_header(0, counter, -1, 0) + bytes(TAG_BYTES))
    assert isinstance(packet, DataPacket)
    assert restore_counter(packet.counter, min(highest, counter - 1)) == counter


@given(st.binary(max_size=1300))
def test_any_bytes_parse_or_give_a_datagram_error(data: bytes) -> None:
    reason_of(data)


@pytest.mark.slow
@given(st.sampled_from([0x94, 0x93]), st.just(VERSION), st.binary(max_size=80))
def test_nearly_valid_bytes_have_one_encoding(prefix: int, version: int, rest: bytes) -> None:
    data = bytes((prefix, version)) + rest
    if reason_of(data) is None:
        assert msgpack.packb(msgpack.unpackb(data)) == data


@pytest.mark.slow
@given(st.integers(0, 127), st.integers(0, MAX_COUNTER), SEALED, st.data())
def test_every_truncation_and_extension_is_rejected(
    session: int, counter: int, sealed: bytes, data: st.DataObject
) -> None:
    whole = data_header(session, counter, -1000, len(sealed) - TAG_BYTES) + sealed
    assert reason_of(whole[: data.draw(st.integers(0, len(whole) - 1))]) is not None
    assert reason_of(whole + b"\0") is not None


@pytest.mark.parametrize("kind", Kind)
def test_every_flipped_bit_and_every_truncation_of_a_handshake_datagram_is_noticed(kind: Kind) -> None:
    data = handshake_datagram(kind, *FIELDS[kind].unpack(bytes(FIELDS[kind].size)))
    for bit in range(8 * len(data)):
        damaged = bytearray(data)
        damaged[bit // 8] ^= 1 << bit % 8
        assert reason_of(bytes(damaged)) is not None, bit
    for size in range(len(data)):
        assert reason_of(data[:size]) is not None


TAG = "00" * 8


@pytest.mark.parametrize(
    ("hexes", "reason"),
    [
        ("", DropReason.SIZE),
        ("94030505c4080000", DropReason.SIZE),
        ("00" * (MAX_DATAGRAM + 1), DropReason.SIZE),
        (f"94010505c408{TAG}", DropReason.VERSION),
        (f"93010005c408{TAG}", DropReason.VERSION),
        (f"95030505c408{TAG}", DropReason.SYNTAX),
        (f"94038005c408{TAG}", DropReason.SYNTAX),  # session 128
        (f"940305cc7fc408{TAG}", DropReason.SYNTAX),  # counter 127 as uint8: not its shortest form
        (f"940305cd00ffc408{TAG}", DropReason.SYNTAX),
        (f"940305ce0000ffffc408{TAG}", DropReason.SYNTAX),
        (f"940305cf0000000100000000c408{TAG}", DropReason.SYNTAX),  # counters end at 2^32
        (f"940305d0ffc408{TAG}", DropReason.SYNTAX),  # a negative counter
        (f"94030505c50008{TAG}", DropReason.SYNTAX),  # bin16 where bin8 would do
        (f"94030505d908{TAG}", DropReason.SYNTAX),  # a string
        (f"94030505c407{TAG}", DropReason.SYNTAX),  # a byte too many
        (f"94030505c409{TAG}", DropReason.SYNTAX),  # a byte too few
        ("94030505c40700000000000000", DropReason.SYNTAX),  # no room for a tag
        ("930306c405057a4a1d9e", DropReason.CHECKSUM),
        ("930307c405057a4a1d9d", DropReason.SYNTAX),  # no such kind
    ],
)
def test_each_error_has_its_reason(hexes: str, reason: DropReason) -> None:
    assert reason_of(bytes.fromhex(hexes)) is reason


def test_a_body_that_does_not_fit_is_refused() -> None:
    with pytest.raises(ValueError, match="a body of 1200 B does not fit a datagram of 1200 B"):
        data_header(0, 0, -1, 1200)
