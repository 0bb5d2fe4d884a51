import random
from collections.abc import Callable
from itertools import count

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, precondition, rule

from conf.errors import ProtocolError
from conf.protocol.portrait.chunk_budget import CHUNK_BYTES, ChunkBudget
from conf.protocol.portrait.chunks import Ack, Chunk, decode_chunk, encode_ack
from conf.protocol.portrait.object_receiver import ObjectReceiver
from conf.protocol.portrait.object_sender import OBJECT_NUMBERS, RETRY_S, STARTUP_RETRY_S, ObjectSender

FPS = 15


class Unlimited(ChunkBudget):
    """A budget that refuses nothing."""

    def consume(self, size: int, now: float, *, overhead: int = 0) -> bool:
        return True


def after_startup() -> ChunkBudget:
    budget = Unlimited()
    budget._startup_left = 0
    return budget


def transfer(
    sender: ObjectSender,
    receiver: ObjectReceiver,
    *,
    seconds: float,
    budget: ChunkBudget | None = None,
    lost: Callable[[], bool] = lambda: False,
    begin: float = 0.0,
) -> list[tuple[float, bytes]]:
    """Run both over a link that loses what `lost()` says; return the objects with their times of arrival."""
    arrived, budget = [], budget or ChunkBudget()
    for frame in range(round(seconds * FPS)):
        now = begin + frame / FPS
        chunk = sender.next_chunk(now, budget)
        if chunk and not lost():
            data = receiver.receive_chunk(chunk)
            if data is not None:
                arrived.append((now, data))
        ack = receiver.next_ack(now)
        if ack and not lost():
            sender.receive_ack(ack)
    return arrived


def next_chunk(sender: ObjectSender, now: float, budget: ChunkBudget) -> Chunk | None:
    data = sender.next_chunk(now, budget)
    return decode_chunk(data) if data else None


def indices(sender: ObjectSender, now: float, budget: ChunkBudget) -> list[int]:
    """Return the indices of all chunks that are due now."""
    found = []
    while chunk := next_chunk(sender, now, budget):
        found.append(chunk.index)
    return found


@pytest.mark.slow
@given(st.integers(0, 2**32 - 1), st.floats(0, 0.5), st.lists(st.integers(1, 900), min_size=1, max_size=5))
def test_everything_arrives_once_and_complete_whatever_is_lost(seed: int, loss: float, sizes: list[int]) -> None:
    generator = random.Random(seed)
    sender, receiver = ObjectSender(), ObjectReceiver(7)
    objects = [generator.randbytes(size) for size in sizes]
    for slot, data in enumerate(objects):
        sender.send_object(slot, data, priority=1)
    arrived = transfer(sender, receiver, seconds=120, lost=lambda: generator.random() < loss)
    assert sorted(data for _, data in arrived) == sorted(objects)
    assert all(sender.delivered(slot) for slot in range(len(objects)))
    assert sender.waiting_bytes == 0 and not receiver._partial and receiver.rejected == 0


def test_a_draft_arrives_in_four_seconds_over_16_kbit_s_with_5_percent_loss() -> None:
    for seed in range(30):
        generator = random.Random(seed)
        sender = ObjectSender()
        sender.send_object(0, bytes(3300), priority=0)
        losses = (generator.random() < 0.05 for _ in count())
        arrived = transfer(sender, ObjectReceiver(), seconds=8, lost=losses.__next__)
        assert arrived and arrived[0][0] < 4.0


def test_chunks_are_cut_from_the_object_in_order() -> None:
    sender = ObjectSender()
    data = random.Random(1).randbytes(2 * CHUNK_BYTES + 5)
    sender.send_object(0, data, priority=0)
    chunks = [next_chunk(sender, 0.0, Unlimited()) for _ in range(3)]
    assert b"".join(chunk.data for chunk in chunks if chunk) == data
    assert [chunk and chunk.index for chunk in chunks] == [0, 1, 2]
    assert next_chunk(sender, 0.0, Unlimited()) is None


def test_the_budget_is_asked_with_body_and_overhead_and_a_refused_chunk_stays_due() -> None:
    asked = []

    class Budget(ChunkBudget):
        def consume(self, size: int, now: float, *, overhead: int = 0) -> bool:
            asked.append((size, now, overhead))
            return len(asked) > 1

    sender, budget = ObjectSender(), Budget()
    sender.send_object(0, bytes(10), priority=0)
    assert sender.next_chunk(5.0, budget, overhead=47) is None
    assert sender.next_chunk(5.0, budget, overhead=2) is not None
    assert asked == [(16, 5.0, 47), (16, 5.0, 2)]


@pytest.mark.parametrize(("budget", "retry_s"), [(Unlimited(), STARTUP_RETRY_S), (after_startup(), RETRY_S)])
def test_an_unacknowledged_chunk_is_sent_again_after_its_time(budget: ChunkBudget, retry_s: float) -> None:
    sender = ObjectSender()
    sender.send_object(0, bytes(2 * CHUNK_BYTES), priority=0)
    assert indices(sender, 0.0, budget) == [0, 1]
    assert indices(sender, retry_s - 0.01, budget) == []
    assert indices(sender, retry_s, budget) == [0, 1]


def test_a_missing_chunk_is_sent_again_at_once_if_a_much_later_one_has_arrived() -> None:
    sender, budget = ObjectSender(), Unlimited()
    sender.send_object(0, bytes(5 * CHUNK_BYTES), priority=0)
    for now in (0.0, 0.1, 0.19, 0.2):
        next_chunk(sender, now, budget)
    sender.receive_ack(encode_ack(Ack(1, (), ((0, frozenset({2})),))))
    assert indices(sender, 0.25, budget) == [0, 4], "chunk 1 may only be reordered, chunk 3 was sent later"
    sender.receive_ack(encode_ack(Ack(1, (), ((0, frozenset({2, 4})),))))
    assert indices(sender, 0.41, budget) == [1]


def test_acknowledged_chunks_are_not_sent_again_and_impossible_ones_ignored() -> None:
    sender, budget = ObjectSender(), Unlimited()
    sender.send_object(0, bytes(3 * CHUNK_BYTES), priority=0)
    assert sender.waiting_bytes == 3 * CHUNK_BYTES
    indices(sender, 0.0, budget)
    sender.receive_ack(encode_ack(Ack(1, (), ((0, frozenset({0, 2, 3, 9})), (5, frozenset({1}))))))
    assert sender.waiting_bytes == CHUNK_BYTES
    assert indices(sender, 9.0, budget) == [1]


def test_the_lowest_priority_number_goes_first_then_the_oldest() -> None:
    sender, receiver = ObjectSender(), ObjectReceiver()
    sender.send_object(5, b"patch", priority=2)
    sender.send_object(7, b"other", priority=2)
    sender.send_object(0, b"old photo", priority=0)
    sender.send_object(0, b"new photo", priority=0)
    arrived = transfer(sender, receiver, seconds=2, budget=Unlimited())
    assert [data for _, data in arrived] == [b"new photo", b"patch", b"other"]


def test_an_object_whose_chunks_are_all_on_their_way_lets_the_next_go() -> None:
    sender, budget = ObjectSender(), Unlimited()
    sender.send_object(0, b"first", priority=0)
    sender.send_object(1, b"second", priority=1)
    assert [(chunk := next_chunk(sender, 0.0, budget)) and chunk.data for _ in range(3)] == [b"first", b"second", None]


def test_a_cancelled_object_is_not_sent() -> None:
    sender = ObjectSender()
    sender.send_object(1, b"patch", priority=2)
    sender.cancel(1)
    sender.cancel(2)
    assert sender.next_chunk(0.0, ChunkBudget()) is None
    sender.send_object(1, b"patch", priority=2)
    transfer(sender, ObjectReceiver(), seconds=1)
    sender.cancel(1)
    assert not sender.delivered(1)


def test_a_new_object_of_a_delivered_slot_is_not_delivered() -> None:
    sender = ObjectSender()
    sender.send_object(1, b"patch", priority=2)
    transfer(sender, ObjectReceiver(), seconds=1)
    assert sender.delivered(1)
    sender.send_object(1, b"another", priority=2)
    assert not sender.delivered(1) and sender.waiting_bytes == 7


def test_a_new_receiver_gets_everything_again() -> None:
    sender = ObjectSender()
    sender.send_object(0, bytes(500), priority=0)
    transfer(sender, ObjectReceiver(1), seconds=4)
    assert sender.delivered(0)
    # Without a chunk the new receiver would not acknowledge anything.
    sender.send_object(1, b"patch", priority=1)
    arrived = transfer(sender, ObjectReceiver(2), seconds=4, begin=10.0)
    assert {data for _, data in arrived} == {bytes(500), b"patch"}


def test_an_ack_tells_whether_the_receiver_is_new() -> None:
    sender = ObjectSender()
    assert [sender.receive_ack(encode_ack(Ack(n, (), ()))) for n in (0, 0, 3, 3, 0)] == [
        *(False, False, True, False, True)
    ]


def test_a_restart_keeps_the_order_of_the_objects() -> None:
    sender, budget = ObjectSender(), Unlimited()
    for slot, data in ((3, b"first"), (1, b"second"), (2, b"third")):
        sender.send_object(slot, data, priority=0)
    sender.receive_ack(encode_ack(Ack(0, (1,), ())))
    assert sender.delivered(1)
    sender.restart()
    assert not sender.delivered(1)
    chunks = [next_chunk(sender, 0.0, budget) for _ in range(3)]
    assert [(c.object_number, c.data) for c in chunks if c] == [(3, b"first"), (4, b"second"), (5, b"third")]


def test_object_numbers_wrap() -> None:
    sender = ObjectSender()
    sender._next_number = OBJECT_NUMBERS - 1
    for slot in range(2):
        sender.send_object(slot, b"x", priority=0)
    assert {t.number for t in sender._transfers.values()} == {65535, 0}


def test_bad_objects_and_acks_are_refused() -> None:
    for size in (0, 12_289):
        with pytest.raises(ValueError, match=f"data must be 1 to 12288 bytes, got {size}"):
            ObjectSender().send_object(0, bytes(size), priority=0)
    ObjectSender().send_object(0, bytes(12_288), priority=0)
    with pytest.raises(ProtocolError):
        ObjectSender().receive_ack(b"?")


class Transfer(RuleBasedStateMachine):
    """Objects over a link that loses, delays and reorders chunks and acks, to a receiver that may start again."""

    def __init__(self) -> None:
        super().__init__()
        self.sender, self.receiver, self.budget = ObjectSender(), ObjectReceiver(1), Unlimited()
        self.now = 0.0
        self.receivers = self.made = 1
        self.current: dict[int, bytes] = {}  # by slot
        self.every: set[bytes] = set()
        self.arrived: list[bytes] = []  # at the present receiver
        self.chunks: list[bytes] = []  # in flight
        self.acks: list[bytes] = []

    @rule(slot=st.integers(0, 3), size=st.integers(1, 400), priority=st.integers(0, 2))
    def send_object(self, slot: int, size: int, priority: int) -> None:
        self.made += 1
        self.current[slot] = self.made.to_bytes(2) * size
        self.every.add(self.current[slot])
        self.sender.send_object(slot, self.current[slot], priority=priority)

    @rule(slot=st.integers(0, 3))
    def cancel(self, slot: int) -> None:
        self.current.pop(slot, None)
        self.sender.cancel(slot)

    @rule(step=st.floats(0.0, 1.0), count=st.integers(1, 8))
    def send(self, step: float, count: int) -> None:
        self.now += step
        for _ in range(count):
            if chunk := self.sender.next_chunk(self.now, self.budget):
                self.chunks.append(chunk)

    @precondition(lambda self: self.chunks)
    @rule(data=st.data(), fate=st.sampled_from(["arrives", "arrives", "is lost", "arrives twice"]))
    def deliver_chunk(self, data: st.DataObject, fate: str) -> None:
        chunk = self.chunks.pop(data.draw(st.integers(0, len(self.chunks) - 1)))
        for _ in range({"arrives": 1, "is lost": 0, "arrives twice": 2}[fate]):
            if (complete := self.receiver.receive_chunk(chunk)) is not None:
                self.arrived.append(complete)

    @rule()
    def acknowledge(self) -> None:
        if ack := self.receiver.next_ack(self.now):
            self.acks.append(ack)

    @precondition(lambda self: self.acks)
    @rule(data=st.data(), is_lost=st.booleans())
    def deliver_ack(self, data: st.DataObject, is_lost: bool) -> None:
        ack = self.acks.pop(data.draw(st.integers(0, len(self.acks) - 1)))
        if not is_lost:
            self.sender.receive_ack(ack)

    @precondition(lambda self: self.receivers < 3)
    @rule()
    def restart_receiver(self) -> None:
        """Acks and chunks of the old session are not authentic in the new one."""
        self.receivers += 1
        self.receiver = ObjectReceiver(self.receivers)
        self.chunks, self.acks, self.arrived = [], [], []
        self.sender.restart()

    @invariant()
    def only_objects_that_were_sent_arrive_and_each_once(self) -> None:
        assert set(self.arrived) <= self.every and len(self.arrived) == len(set(self.arrived))
        assert self.receiver.rejected == 0

    @invariant()
    def what_the_sender_takes_for_delivered_has_arrived(self) -> None:
        assert all(self.current[slot] in self.arrived for slot in self.current if self.sender.delivered(slot))

    @invariant()
    def waiting_bytes_are_those_of_undelivered_objects(self) -> None:
        waiting = sum(len(data) for slot, data in self.current.items() if not self.sender.delivered(slot))
        assert 0 <= self.sender.waiting_bytes <= waiting
        assert len(self.receiver._partial) <= 4

    def teardown(self) -> None:
        arrived = transfer(self.sender, self.receiver, seconds=30, budget=self.budget, begin=self.now + 1)
        self.arrived += [data for _, data in arrived]
        assert all(self.sender.delivered(slot) for slot in self.current)
        assert set(self.current.values()) <= set(self.arrived)


TestTransfer = pytest.mark.slow(Transfer.TestCase)
TestTransfer.settings = settings(max_examples=40, stateful_step_count=40)
