"""Sealed bodies open once, in any order; nothing else opens; keys change by themselves."""

import pytest
from cryptography.hazmat.primitives.ciphers.aead import AESCCM
from hypothesis import given
from hypothesis import strategies as st

from conf.protocol.session import seal
from conf.protocol.session.drop_reasons import DatagramError, DropReason
from conf.protocol.session.packet import DataPacket, parse_datagram
from conf.protocol.session.seal import CounterExhausted, KeyChain, OpeningKey, SealingKey
from tests.protocol.session.test_golden import hkdf_expand
from tests.support.simulated_sessions import state

SECRET = bytes(range(32))


def open_datagram(opening_key: OpeningKey, data: bytes) -> tuple[int, bytes]:
    packet = parse_datagram(data)
    assert isinstance(packet, DataPacket)
    return opening_key.open(packet)


def reason_of(opening_key: OpeningKey, data: bytes) -> DropReason:
    before = state(opening_key)
    with pytest.raises(DatagramError) as caught:
        open_datagram(opening_key, data)
    assert state(opening_key) == before
    return caught.value.reason


@pytest.mark.slow
@given(st.lists(st.binary(max_size=300), max_size=20), st.integers(4, 40))
def test_bodies_open_in_any_order_once_across_key_changes(bodies: list[bytes], epoch: int) -> None:
    sealing_key, opening_key = SealingKey(7, SECRET, epoch_length=epoch), OpeningKey(SECRET, epoch_length=epoch)
    datagrams = [(index, body, sealing_key.seal(body)) for index, body in enumerate(bodies)]
    for index, body, data in sorted(datagrams, key=lambda d: (d[0] // 4, -d[0])):  # fours, each back to front
        assert open_datagram(opening_key, data) == (index, body)
    for *_, data in datagrams:
        assert reason_of(opening_key, data) is DropReason.REPLAYED


def test_a_key_change_costs_no_byte_and_old_keys_are_dropped() -> None:
    sealing_key, opening_key = SealingKey(7, SECRET, epoch_length=4), OpeningKey(SECRET, epoch_length=4)
    datagrams = []
    for counter in range(16):
        data = sealing_key.seal(b"body")
        datagrams.append(data)
        sealing_key.acknowledge(counter)
        assert open_datagram(opening_key, data) == (counter, b"body")
    assert {len(data) for data in datagrams} == {18}
    assert sorted(opening_key._keys) == [2, 3, 4]


def test_each_epoch_and_direction_has_its_own_key_and_salt() -> None:
    chain, other = KeyChain(SECRET), KeyChain(bytes(32))
    keys = [chain.next_key(), chain.next_key(), other.next_key()]
    sealed = {key.cipher.encrypt(bytes(13), b"body", b"") for key in keys}
    assert len(sealed) == len({key.salt for key in keys}) == 3


def test_a_counter_beyond_the_next_epoch_is_refused_before_any_work() -> None:
    sealing_key, opening_key = SealingKey(7, SECRET, epoch_length=100), OpeningKey(SECRET, epoch_length=100)
    datagrams = [sealing_key.seal(b"") for _ in range(201)]
    assert reason_of(opening_key, datagrams[200]) is DropReason.COUNTER
    assert open_datagram(opening_key, datagrams[150]) == (150, b"")
    assert open_datagram(opening_key, datagrams[200]) == (200, b"")


def test_a_datagram_with_a_flipped_bit_is_dropped_and_changes_nothing() -> None:
    opening_key = OpeningKey(SECRET)
    sealing_key = SealingKey(7, SECRET)
    data = [sealing_key.seal(b"body") for _ in range(3)][2]
    for bit in range(8 * len(data)):
        damaged = bytearray(data)
        damaged[bit // 8] ^= 1 << bit % 8
        before = state(opening_key)
        with pytest.raises(DatagramError):
            open_datagram(opening_key, bytes(damaged))
        assert state(opening_key) == before
    assert open_datagram(opening_key, data) == (2, b"body")


def test_a_datagram_behind_the_window_is_too_old() -> None:
    sealing_key, opening_key = SealingKey(7, SECRET), OpeningKey(SECRET)
    datagrams = [sealing_key.seal(b"") for _ in range(300)]
    open_datagram(opening_key, datagrams[299])
    assert reason_of(opening_key, datagrams[200]) is DropReason.TOO_OLD


def test_counters_are_used_once_and_end() -> None:
    sealing_key = SealingKey(7, SECRET, epoch_length=1 << 32)
    sealing_key.counter = 0xFFFFFFFF
    assert sealing_key.seal(b"")[:8].hex() == "940307ceffffffff"
    with pytest.raises(CounterExhausted):
        sealing_key.seal(b"")


def test_a_body_too_long_uses_no_counter() -> None:
    sealing_key = SealingKey(7, SECRET)
    with pytest.raises(ValueError, match="does not fit"):
        sealing_key.seal(bytes(1190))
    assert sealing_key.counter == 0


def test_acknowledging_what_was_not_sent_is_ignored() -> None:
    sealing_key = SealingKey(7, SECRET)
    for _ in range(200):
        sealing_key.seal(b"")
    sealing_key.acknowledge(10**6)
    assert len(sealing_key.seal(b"")) == 15
    sealing_key.acknowledge(199)
    sealing_key.acknowledge(3)
    assert len(sealing_key.seal(b"")) == 14


def test_nonces_are_thirteen_bytes() -> None:
    assert len(KeyChain(SECRET).next_key().nonce(5)) == 13
    assert seal.EPOCH_LENGTH == 1 << 20


def test_keys_are_derived_as_wire_md_describes() -> None:
    """HKDF-Expand with SHA-256, in 53 bytes: key, salt, and the secret of the next epoch."""
    chain, secret = KeyChain(SECRET), SECRET
    for _ in range(3):
        material = hkdf_expand(secret, b"conf epoch", 53)
        key, secret = chain.next_key(), material[21:]
        assert key.salt == material[16:21]
        sealed = key.cipher.encrypt(key.nonce(7), b"body", b"header")
        assert sealed == AESCCM(material[:16], tag_length=8).encrypt(
            material[16:21] + bytes(7) + b"\7", b"body", b"header"
        )
