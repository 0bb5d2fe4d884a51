import random

import pytest

from conf.protocol.portrait.queue_delay import QueueDelayModel

RATE = 2000.0


def test_a_piece_on_an_empty_link_costs_the_time_it_takes() -> None:
    hindrance = QueueDelayModel(RATE)
    assert hindrance.added_delay(100, 1.0) == pytest.approx(0.05)
    hindrance.add(100, 1.0)
    assert hindrance.added_delay(0, 1.02) == pytest.approx(0.03)
    assert hindrance.added_delay(0, 2.0) == 0


def test_what_motion_itself_makes_wait_is_not_counted() -> None:
    hindrance = QueueDelayModel(RATE)
    for step in range(10):
        hindrance.add_motion(400, step / 100)
    assert hindrance.added_delay(100, 0.1) == pytest.approx(0.05)


def test_behind_motion_a_piece_hinders_until_the_queue_is_gone() -> None:
    hindrance = QueueDelayModel(RATE)
    hindrance.add_motion(200, 0.0)
    hindrance.add(100, 0.0)
    assert hindrance.added_delay(0, 0.1) == pytest.approx(0.05), "the motion would be through, the piece is in the way"
    assert hindrance.added_delay(0, 0.15) == pytest.approx(0.0)


def test_it_is_what_a_real_queue_does() -> None:
    """Two queues, served byte by byte: with the pieces and without."""
    rng = random.Random(3)
    hindrance = QueueDelayModel(RATE)
    free_all = free_motion = now = 0.0
    for _ in range(500):
        now += rng.expovariate(20)
        size = rng.randrange(40, 140)
        free_all = max(free_all, now) + size / RATE
        if rng.random() < 0.5:
            hindrance.add(size, now)
        else:
            hindrance.add_motion(size, now)
            free_motion = max(free_motion, now) + size / RATE
        waits = max(free_all - now, 0) - max(free_motion - now, 0)
        assert hindrance.added_delay(0, now) == pytest.approx(waits, abs=1e-9)
