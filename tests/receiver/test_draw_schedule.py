import pytest

from conf.receiver.draw_schedule import DrawSchedule


def drawn(schedule: DrawSchedule, seconds: float, *, drawing_s: float, is_flood: bool = False) -> list[float]:
    """Return the times at which frames are drawn. drawing_s : how long each takes"""
    now, times = 0.0, []
    while now < seconds:
        if schedule.is_due(now, is_flood=is_flood):
            times.append(now)
            now += drawing_s
        now = max(now + 1e-3, schedule.next_step(now) if not is_flood else 0.0)
    return times


def test_frames_are_drawn_at_the_rate() -> None:
    assert len(drawn(DrawSchedule(25.0), 4.0, drawing_s=0.01)) == pytest.approx(100, abs=4)


def test_a_slow_machine_draws_one_after_another_without_a_burst() -> None:
    times = drawn(DrawSchedule(50.0), 4.0, drawing_s=0.1)
    assert len(times) == pytest.approx(40, abs=2)


def test_in_a_flood_as_much_time_is_spent_on_datagrams_as_on_drawing() -> None:
    schedule = DrawSchedule(50.0)
    schedule.is_due(0.0, is_flood=False)
    assert len(drawn(schedule, 4.0, drawing_s=0.1, is_flood=True)) == pytest.approx(20, abs=2)


def test_after_a_frame_the_next_step_is_due_at_once() -> None:
    schedule = DrawSchedule(10.0)
    assert schedule.next_step(5.0) == 5.0
    assert schedule.is_due(5.0, is_flood=False) and schedule.next_step(5.0) == 5.0
    assert not schedule.is_due(5.02, is_flood=False) and schedule.next_step(5.02) == pytest.approx(5.1)
