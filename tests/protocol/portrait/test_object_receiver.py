from hypothesis import given
from hypothesis import strategies as st

from conf.protocol.portrait import ObjectReceiver
from conf.protocol.portrait.chunks import MAX_OBJECT, MAX_UNFINISHED, Chunk, decode_answer, encode_piece


def piece(number: int, index: int, *, total: int = 160, size: int = 80) -> bytes:
    return encode_piece(Chunk(number, size, index, total, bytes([index]) * min(size, total - size * index)))


def test_pieces_in_any_order_make_the_object_once() -> None:
    inbox = ObjectReceiver()
    assert inbox.receive_chunk(piece(3, 1)) is None
    assert inbox.receive_chunk(piece(3, 0)) == bytes(80) + b"\1" * 80
    assert inbox.receive_chunk(piece(3, 0)) is None


def test_contradictions_and_garbage_are_refused_and_counted() -> None:
    inbox = ObjectReceiver()
    inbox.receive_chunk(piece(3, 0))
    inbox.receive_chunk(piece(3, 1, total=200))
    inbox.receive_chunk(b"garbage")
    assert inbox.rejected == 2
    assert inbox.receive_chunk(piece(3, 1)) is not None


@given(st.lists(st.tuples(st.integers(0, 65535), st.integers(0, 150)), max_size=300))
def test_what_is_kept_is_bounded(pieces: list[tuple[int, int]]) -> None:
    inbox = ObjectReceiver()
    for number, index in pieces:
        inbox.receive_chunk(piece(number, index, total=MAX_OBJECT))
    assert inbox.held_bytes <= MAX_UNFINISHED * MAX_OBJECT


@given(st.lists(st.binary(max_size=100), max_size=50))
def test_any_bytes_do_no_harm(pieces: list[bytes]) -> None:
    inbox = ObjectReceiver()
    for step, data in enumerate(pieces):
        inbox.receive_chunk(data)
        if answer := inbox.next_ack(step / 10):
            decode_answer(answer)


def test_answers_come_at_the_end_of_an_object_and_otherwise_twice_a_second() -> None:
    inbox = ObjectReceiver(9)
    assert inbox.next_ack(0.0) is None
    inbox.receive_chunk(piece(1, 0, total=400))
    assert decode_answer(inbox.next_ack(0.0) or b"").partial == ((1, frozenset({0})),)
    inbox.receive_chunk(piece(1, 1, total=400))
    assert inbox.next_ack(0.1) is None
    inbox.receive_chunk(piece(1, 4, total=400))
    assert decode_answer(inbox.next_ack(0.2) or b"").partial == ((1, frozenset({0, 1, 4})),)
    for index in (2, 3):
        inbox.receive_chunk(piece(1, index, total=400))
    answer = decode_answer(inbox.next_ack(0.3) or b"")
    assert (answer.token, answer.complete, answer.partial) == (9, (1,), ())
    inbox.receive_chunk(piece(1, 0, total=400))  # the answer was lost, the sender tries again
    assert decode_answer(inbox.next_ack(0.4) or b"").complete == (1,)
