import random

import pytest

from conf.protocol.portrait.queue_delay import QueueDelayModel

RATE = 2000.0


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
