import random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.protocol.portrait.chunk_budget import (
    BURST_CHUNKS,
    CHUNK_BYTES,
    DEFAULT_KBPS,
    MAX_ADDED_DELAY_S,
    STARTUP_BYTES,
    STARTUP_RATE_FACTOR,
    STARTUP_S,
    ChunkBudget,
    QueueDelayModel,
)

FPS = 15
BODY = 82
RATE = 2000.0


def exhaust_startup(budget: ChunkBudget) -> float:
    """Take chunks until the startup is over. Returns the time after a pause that fills every bucket."""
    now = 0.0
    while budget.in_startup:
        budget.consume(BODY, now, overhead=2)
        now += 0.01
    return now + 100.0


@pytest.mark.slow
@given(st.integers(0, 2**32 - 1), st.booleans())
def test_motion_never_waits_longer_than_a_frame_for_chunks(seed: int, piggyback: bool) -> None:
    """A link of 16 kbit/s whose queue is simulated with the chunks and without."""
    generator = random.Random(seed)
    budget = ChunkBudget()
    with_chunks = alone = now = 0.0  # when the link will be free
    for _ in range(600):
        now += generator.choice((0.01, 1 / FPS, 1 / FPS, 1 / FPS, 0.2))
        motion = generator.choice((0, 50, 55, 60, 110))
        budget.add_motion(motion, now)
        overhead = 2 if piggyback and motion else 47
        size = motion + (BODY + overhead if budget.consume(BODY, now, overhead=overhead) else 0)
        with_chunks = max(with_chunks, now) + size / 2000
        alone = max(alone, now) + motion / 2000
        assert with_chunks - max(alone, now) <= 1 / FPS + 1e-9
    assert not budget.in_startup


@pytest.mark.slow
@given(st.floats(0.5, 20), st.floats(2, 12))
def test_the_long_term_rate_holds_beside_the_startup(kbps: float, seconds: float) -> None:
    budget, sent = ChunkBudget(kbps), 0
    for step in range(round(seconds * 100)):
        sent += 42 + BODY if budget.consume(BODY, step / 100, overhead=42) else 0
    startup = min((STARTUP_BYTES / BODY + 1) * (BODY + 42), STARTUP_RATE_FACTOR * kbps * 125 * seconds)
    assert sent == budget.bytes_sent <= startup + kbps * 125 * seconds + 300


def test_the_startup_is_faster_and_bounded() -> None:
    budget, spent = ChunkBudget(), {}
    for step in range(6000):
        budget.consume(BODY, step / 100, overhead=2)
        spent[step // 1000] = budget.bytes_sent
    assert spent[0] > STARTUP_BYTES
    assert 4 * 125 * 40 - 300 <= spent[5] - spent[1] <= 4 * 125 * 40 + 100


def test_during_startup_the_chunks_have_what_the_motion_leaves() -> None:
    spent = []
    for motion in (0, 60):
        budget = ChunkBudget()
        for frame in range(4 * FPS):
            budget.add_motion(motion, frame / FPS)
            budget.consume(BODY, frame / FPS, overhead=2 if motion else 47)
        spent.append(budget.bytes_sent + 4 * FPS * motion)
    assert all(total <= STARTUP_RATE_FACTOR * 4 * 125 * 4 + 300 for total in spent)
    assert spent[1] > 0.9 * spent[0]


def test_the_startup_counts_bodies_without_overhead() -> None:
    budget = ChunkBudget(1000.0)
    for step in range(-(-STARTUP_BYTES // 80)):
        assert budget.in_startup
        assert budget.consume(80, step / 20, overhead=40)
    assert not budget.in_startup
    budget.restart()
    assert budget.in_startup


def test_after_startup_the_burst_is_three_chunks() -> None:
    budget = ChunkBudget(100.0)  # 48,750 B/s in startup: no delay matters
    now = exhaust_startup(budget)
    assert BURST_CHUNKS * CHUNK_BYTES == 228
    assert [budget.consume(76, now) for _ in range(4)] == [True, True, True, False]
    assert not budget.consume(76, now + 75 / 12_500) and budget.consume(76, now + 77 / 12_500)


def test_a_chunk_that_would_delay_motion_is_refused() -> None:
    """At the default rate the modelled link has 1,950 B/s: 130 B take a frame's time."""
    budget = ChunkBudget()
    now = exhaust_startup(budget)
    assert not budget.consume(84, now, overhead=47)
    assert budget.consume(83, now, overhead=47)
    assert not budget.consume(10, now)
    assert MAX_ADDED_DELAY_S == pytest.approx(1 / FPS) and DEFAULT_KBPS == 4.0


def test_the_startup_rate_is_shared_with_motion_and_ends_with_the_startup() -> None:
    """4 ms after a burst the link has 195 B for chunks of 76 B, less the motion; the chunks' own rate gives 50 B."""
    for startup_left, motion, taken in ((9000, 0, 2), (9000, 100, 1), (9000, 100_000, 0), (3 * 76, 0, 0)):
        budget = ChunkBudget(100.0)
        budget._startup_left = startup_left
        assert [budget.consume(76, 0.0) for _ in range(3)] == [True, True, True]
        budget.add_motion(motion, 0.0)
        assert sum(budget.consume(76, 0.004) for _ in range(9)) == taken


def test_bytes_on_an_empty_link_add_the_time_they_take() -> None:
    model = QueueDelayModel(RATE)
    assert model.added_delay(100, 1.0) == pytest.approx(0.05)
    model.add(100, 1.0)
    assert model.added_delay(0, 1.02) == pytest.approx(0.03)
    assert model.added_delay(0, 2.0) == 0


def test_a_clock_that_goes_back_drains_nothing() -> None:
    model = QueueDelayModel(RATE)
    model.add(100, 1.0)
    assert model.added_delay(0, 0.5) == pytest.approx(0.05)


def test_the_delay_of_motion_behind_motion_is_not_counted() -> None:
    model = QueueDelayModel(RATE)
    for step in range(10):
        model.add_motion(400, step / 100)
    assert model.added_delay(100, 0.1) == pytest.approx(0.05)


def test_bytes_behind_motion_add_delay_until_the_queue_is_empty() -> None:
    model = QueueDelayModel(RATE)
    model.add_motion(200, 0.0)
    model.add(100, 0.0)
    assert model.added_delay(0, 0.1) == pytest.approx(0.05), "the motion alone would have left the queue"
    assert model.added_delay(0, 0.15) == pytest.approx(0.0)


def test_the_model_agrees_with_two_simulated_queues() -> None:
    """One queue with all bytes, one with the motion alone."""
    generator = random.Random(3)
    model = QueueDelayModel(RATE)
    free_all = free_motion = now = 0.0
    for _ in range(500):
        now += generator.expovariate(20)
        size = generator.randrange(40, 140)
        free_all = max(free_all, now) + size / RATE
        if generator.random() < 0.5:
            model.add(size, now)
        else:
            model.add_motion(size, now)
            free_motion = max(free_motion, now) + size / RATE
        waits = max(free_all - now, 0) - max(free_motion - now, 0)
        assert model.added_delay(0, now) == pytest.approx(waits, abs=1e-9)


@pytest.mark.parametrize(("motion", "expected"), [(0, 4.0), (42, 1.98), (48, 1.26), (54, 0.54), (90, 1.1)])
def test_after_the_startup_motion_and_chunks_have_a_joint_rate(motion: int, expected: float) -> None:
    """Motion of so many bytes a frame: chunks have 7.02 kbit/s less the motion, at most 4, and 1.1 beside more."""
    budget = ChunkBudget()
    now = exhaust_startup(budget)
    for frame in range(20 * FPS):
        budget.add_motion(motion, now + frame / FPS)
    now += 20
    spent = budget.bytes_sent
    for frame in range(60 * FPS):
        budget.add_motion(motion, now + frame / FPS)
        budget.consume(76, now + frame / FPS, overhead=2)
    assert (budget.bytes_sent - spent) * 8 / 60_000 == pytest.approx(expected, abs=0.12)


@given(st.integers(0, 2**32 - 1))
def test_lively_motion_and_chunks_keep_their_joint_rate_over_twenty_seconds(seed: int) -> None:
    """Motion of 6 kbit/s in the mean, in seconds of 4.8 and of 7.4: its peaks are saved by the chunks afterwards."""
    generator, budget = random.Random(seed), ChunkBudget()
    start = exhaust_startup(budget)
    sent: list[int] = []
    for _ in range(40):
        motion = generator.choice((40, 40, 60))
        for _ in range(FPS):
            now = start + len(sent) / FPS
            budget.add_motion(motion, now)
            before = budget.bytes_sent
            budget.consume(76, now, overhead=2)
            sent.append(motion + budget.bytes_sent - before)
    window = 20 * FPS
    sums = [sum(sent[i : i + window]) for i in range(len(sent) - window)]
    assert max(sums) * 8 / 20_000 <= 7.2


def test_the_startup_ends_in_time_and_begins_again_with_a_new_receiver() -> None:
    budget = ChunkBudget()
    assert budget.consume(BODY, 3.0) and budget.in_startup
    budget.consume(BODY, 3.0 + STARTUP_S)
    assert not budget.in_startup
    budget.restart()
    assert budget.in_startup and budget.consume(BODY, 60.0) and budget.in_startup
