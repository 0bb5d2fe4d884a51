import random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.errors import ProtocolError
from conf.protocol.portrait import ObjectReceiver, ObjectSender
from conf.protocol.portrait.chunks import PIECE_HEADER
from conf.protocol.portrait.object_sender import PIECE_BYTES, START_BYTES, STARTUP_RATE_FACTOR

FPS = 15


def converse(outbox: ObjectSender, inbox: ObjectReceiver, *, seconds: float, lost: object) -> list[tuple[float, bytes]]:
    """Let the two talk over a link that loses what `lost()` says; return the objects with their times."""
    arrived = []
    for frame in range(round(seconds * FPS)):
        now = frame / FPS
        piece = outbox.next_chunk(now)
        if piece and not lost():
            data = inbox.receive_chunk(piece)
            if data is not None:
                arrived.append((now, data))
        answer = inbox.next_ack(now)
        if answer and not lost():
            outbox.receive_answer(answer)
    return arrived


@given(st.integers(0, 2**32 - 1), st.floats(0, 0.5), st.lists(st.integers(1, 900), min_size=1, max_size=5))
def test_everything_arrives_once_and_whole_whatever_is_lost(seed: int, loss: float, sizes: list[int]) -> None:
    rng = random.Random(seed)
    outbox, inbox = ObjectSender(), ObjectReceiver(7)
    objects = [rng.randbytes(size) for size in sizes]
    for slot, data in enumerate(objects):
        outbox.send_object(slot, data, priority=1)
    arrived = converse(outbox, inbox, seconds=120, lost=lambda: rng.random() < loss)
    assert sorted(data for _, data in arrived) == sorted(objects)
    assert all(outbox.delivered(slot) for slot in range(len(objects)))
    assert outbox.waiting_bytes == 0 and inbox.held_bytes == 0 and inbox.rejected == 0


def test_a_draft_is_there_in_four_seconds_over_16_kbit_s_with_5_percent_loss() -> None:
    for seed in range(30):
        rng = random.Random(seed)
        outbox, inbox = ObjectSender(), ObjectReceiver()
        outbox.send_object(0, bytes(3300), priority=0)
        arrived = converse(outbox, inbox, seconds=8, lost=lambda rng=rng: rng.random() < 0.05)
        assert arrived and arrived[0][0] < 4.0


@given(st.integers(0, 2**32 - 1), st.booleans())
def test_motion_never_waits_longer_than_a_frame_for_pieces(seed: int, riding: bool) -> None:
    """A link of 16 kbit/s, motion as it comes, answers that may be lost: what both queues would be is counted here."""
    rng = random.Random(seed)
    outbox = ObjectSender()
    outbox.send_object(0, bytes(12_000), priority=0)
    with_pieces = alone = now = 0.0  # when the link will be free
    for _ in range(600):
        now += rng.choice((0.01, 1 / FPS, 1 / FPS, 1 / FPS, 0.2))
        motion = rng.choice((0, 50, 55, 60, 110))
        outbox.account_motion(motion, now)
        overhead = 2 if riding and motion else 47
        piece = outbox.next_chunk(now, overhead=overhead)
        size = motion + (len(piece) + overhead if piece else 0)
        with_pieces = max(with_pieces, now) + size / 2000
        alone = max(alone, now) + motion / 2000
        assert with_pieces - max(alone, now) <= 1 / FPS + 1e-9
    assert not outbox.in_startup


@given(st.floats(0.5, 20), st.floats(2, 12))
def test_the_budget_holds(kbps: float, seconds: float) -> None:
    outbox = ObjectSender(kbps=kbps)
    for slot in range(40):
        outbox.send_object(slot, bytes(1000), priority=1)
    sent = 0
    for step in range(round(seconds * 100)):
        piece = outbox.next_chunk(step / 100, overhead=42)
        sent += len(piece) + 42 if piece else 0
    heads = (START_BYTES / PIECE_BYTES + 1) * (42 + PIECE_HEADER)
    start = min(START_BYTES + heads + 128, STARTUP_RATE_FACTOR * kbps * 125 * seconds)
    assert sent == outbox.bytes_sent <= start + kbps * 125 * seconds + 300


def test_the_start_is_faster_but_bounded_though_nobody_answers() -> None:
    outbox = ObjectSender(kbps=4)
    outbox.send_object(0, bytes(12_000), priority=0)
    spent = {}
    for step in range(6000):
        outbox.next_chunk(step / 100, overhead=2)
        spent[step // 1000] = outbox.bytes_sent
    assert spent[0] > START_BYTES
    assert spent[5] - spent[1] <= 4 * 125 * 40 + 100


def test_the_most_urgent_goes_first_and_a_newer_object_takes_the_slot() -> None:
    outbox, inbox = ObjectSender(kbps=1000), ObjectReceiver()
    outbox.send_object(5, b"patch", priority=2)
    outbox.send_object(0, b"old photograph", priority=0)
    outbox.send_object(0, b"new photograph", priority=0)
    arrived = converse(outbox, inbox, seconds=2, lost=lambda: False)
    assert [data for _, data in arrived] == [b"new photograph", b"patch"]


def test_what_is_dropped_is_not_sent() -> None:
    outbox = ObjectSender()
    outbox.send_object(1, b"patch", priority=2)
    outbox.cancel(1)
    assert outbox.next_chunk(0.0) is None


def test_a_receiver_that_begins_anew_gets_everything_again() -> None:
    outbox = ObjectSender()
    outbox.send_object(0, bytes(500), priority=0)
    converse(outbox, ObjectReceiver(1), seconds=4, lost=lambda: False)
    assert outbox.delivered(0)
    fresh = ObjectReceiver(2)
    # Something must be sent for a receiver to answer at all; the sender restarts when it hears another token.
    outbox.send_object(1, b"patch", priority=1)
    arrived = []
    for frame in range(60):
        now = 10 + frame / FPS
        if (piece := outbox.next_chunk(now)) and (data := fresh.receive_chunk(piece)):
            arrived.append(data)
        if answer := fresh.next_ack(now):
            outbox.receive_answer(answer)
    assert bytes(500) in arrived and b"patch" in arrived


def test_refuses_what_cannot_be_sent() -> None:
    with pytest.raises(ValueError, match="data must be 1 to 12288 bytes"):
        ObjectSender().send_object(0, bytes(20_000), priority=0)
    with pytest.raises(ValueError, match="piece_bytes must be a multiple of 4"):
        ObjectSender(piece_bytes=50)
    with pytest.raises(ProtocolError):
        ObjectSender().receive_answer(b"?")


def test_at_the_start_the_pieces_have_what_the_motion_leaves() -> None:
    spent = []
    for motion in (0, 60):
        outbox = ObjectSender()
        outbox.send_object(0, bytes(12_000), priority=0)
        for frame in range(4 * FPS):
            outbox.account_motion(motion, frame / FPS)
            outbox.next_chunk(frame / FPS, overhead=2 if motion else 47)  # it rides, or goes by itself
        spent.append(outbox.bytes_sent + 4 * FPS * motion)
    assert all(total <= STARTUP_RATE_FACTOR * 4 * 125 * 4 + 300 for total in spent)
    assert spent[1] > 0.9 * spent[0]
