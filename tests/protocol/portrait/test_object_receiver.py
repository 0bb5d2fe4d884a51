import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.protocol.portrait.chunks import (
    MAX_COMPLETE,
    MAX_OBJECT_BYTES,
    MAX_PARTIAL,
    Ack,
    Chunk,
    decode_ack,
    encode_chunk,
)
from conf.protocol.portrait.object_receiver import ACK_INTERVAL_S, MAX_REMEMBERED, ObjectReceiver


def chunk(number: int, index: int, *, object_size: int = 160, size: int = 80) -> bytes:
    data = bytes([index]) * min(size, object_size - size * index)
    return encode_chunk(Chunk(number, size, index, object_size, data))


def held_bytes(receiver: ObjectReceiver) -> int:
    return sum(len(data) for partial in receiver._partial.values() for data in partial.chunks.values())


def ack(receiver: ObjectReceiver, now: float) -> Ack | None:
    data = receiver.next_ack(now)
    return decode_ack(data) if data else None


def test_chunks_in_any_order_make_the_object_once() -> None:
    receiver = ObjectReceiver()
    assert receiver.receive_chunk(chunk(3, 1)) is None
    assert held_bytes(receiver) == 80
    assert receiver.receive_chunk(chunk(3, 0)) == bytes(80) + b"\1" * 80
    assert receiver.receive_chunk(chunk(3, 0)) is None
    assert held_bytes(receiver) == 0 and receiver.rejected == 0


def test_how_much_of_a_photo_has_arrived_is_known_from_its_first_chunk_on() -> None:
    receiver = ObjectReceiver()
    assert receiver.photo_percent is None
    receiver.receive_chunk(chunk(3, 1, object_size=240))
    assert receiver.photo_percent is None
    receiver.receive_chunk(chunk(3, 0, object_size=240))
    assert receiver.photo_percent == 66
    receiver.receive_chunk(encode_chunk(Chunk(4, 80, 0, 160, b"\2" * 80)))
    assert receiver.photo_percent == 66, "a patch is no photo"
    receiver.receive_chunk(chunk(3, 2, object_size=240))
    assert receiver.photo_percent == 100
    receiver.receive_chunk(chunk(5, 0))
    assert receiver.photo_percent == 50


def test_contradictions_and_junk_are_rejected_and_counted() -> None:
    receiver = ObjectReceiver()
    receiver.receive_chunk(chunk(3, 0))
    receiver.receive_chunk(chunk(3, 1, object_size=200))
    receiver.receive_chunk(chunk(3, 1, object_size=160, size=84))
    receiver.receive_chunk(b"junk")
    assert receiver.rejected == 3
    assert receiver.receive_chunk(chunk(3, 1)) is not None


@pytest.mark.slow
@given(st.lists(st.tuples(st.integers(0, 65535), st.integers(0, 150)), max_size=300))
def test_memory_is_bounded(chunks: list[tuple[int, int]]) -> None:
    receiver = ObjectReceiver()
    for number, index in chunks:
        receiver.receive_chunk(chunk(number, index, object_size=MAX_OBJECT_BYTES))
    assert held_bytes(receiver) <= MAX_PARTIAL * MAX_OBJECT_BYTES
    assert len(receiver._partial) <= MAX_PARTIAL


def test_of_too_many_partial_objects_the_one_untouched_for_longest_is_dropped() -> None:
    receiver = ObjectReceiver()
    for number in (1, 2, 3, 4):
        receiver.receive_chunk(chunk(number, 0, object_size=400))
    receiver.receive_chunk(chunk(1, 1, object_size=400))
    receiver.receive_chunk(chunk(5, 0, object_size=400))
    assert list(receiver._partial) == [3, 4, 1, 5]


def test_late_chunks_are_ignored_until_the_number_is_forgotten() -> None:
    receiver = ObjectReceiver()
    for number in range(MAX_REMEMBERED + 1):
        assert receiver.receive_chunk(chunk(number, 0, object_size=4)) is not None
    assert receiver.receive_chunk(chunk(1, 0, object_size=4)) is None
    assert receiver.receive_chunk(chunk(0, 0, object_size=4)) is not None


@given(st.lists(st.binary(max_size=100), max_size=50))
def test_any_bytes_are_harmless(chunks: list[bytes]) -> None:
    receiver = ObjectReceiver()
    for step, data in enumerate(chunks):
        receiver.receive_chunk(data)
        ack(receiver, step / 10)


def test_acks_come_at_once_at_the_end_of_an_object_and_else_twice_a_second() -> None:
    receiver = ObjectReceiver(9)
    assert ack(receiver, 0.0) is None
    receiver.receive_chunk(chunk(1, 0, object_size=400))
    assert ack(receiver, 0.0) == Ack(9, (), ((1, frozenset({0})),))
    receiver.receive_chunk(chunk(1, 1, object_size=400))
    assert ack(receiver, 0.1) is None
    receiver.receive_chunk(chunk(1, 4, object_size=400))
    assert ack(receiver, 0.2) == Ack(9, (), ((1, frozenset({0, 1, 4})),))
    for index in (2, 3):
        receiver.receive_chunk(chunk(1, index, object_size=400))
    assert ack(receiver, 0.3) == Ack(9, (1,), ())
    assert ack(receiver, 9.0) is None, "nothing new"
    receiver.receive_chunk(chunk(1, 0, object_size=400))  # the ack was lost and the sender tries again
    assert ack(receiver, 9.1) == Ack(9, (1,), ())


def test_the_interval_of_acks() -> None:
    receiver = ObjectReceiver()
    receiver.receive_chunk(chunk(1, 0, object_size=400))
    assert ack(receiver, 10.0) == Ack(0, (), ((1, frozenset({0})),))
    receiver.receive_chunk(chunk(1, 1, object_size=400))
    assert ack(receiver, 10.0 + ACK_INTERVAL_S - 0.01) is None
    assert ack(receiver, 10.0 + ACK_INTERVAL_S) is not None


def test_an_ack_holds_a_limited_number_of_objects_and_the_next_one_the_rest() -> None:
    receiver = ObjectReceiver(0x1_0005)
    for number in range(MAX_COMPLETE + 3):
        receiver.receive_chunk(chunk(number, 0, object_size=4))
    assert ack(receiver, 0.0) == Ack(5, tuple(range(MAX_COMPLETE)), ())
    assert ack(receiver, 0.0) == Ack(5, tuple(range(MAX_COMPLETE, MAX_COMPLETE + 3)), ())
    assert ack(receiver, 9.0) is None
