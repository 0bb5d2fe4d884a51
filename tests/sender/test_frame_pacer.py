import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.sender.frame_pacer import MAX_LAG_S, FramePacer


@pytest.mark.slow
@given(st.floats(8, 60), st.floats(5, 30), st.floats(0, 1e6))
def test_frames_are_dropped_down_to_the_rate_and_never_repeated(source_fps: float, fps: float, clock: float) -> None:
    pacer = FramePacer(fps)
    timestamps = np.arange(0, 20, 1 / source_fps)
    sent = [t for t in timestamps if pacer.delay_for(float(t), clock + float(t)) is not None]
    assert len(sent) / 20 == pytest.approx(min(fps, source_fps), rel=0.02, abs=0.1)


def test_a_clip_read_ahead_is_delayed_to_its_own_speed() -> None:
    pacer = FramePacer(15)
    now = 50.0
    for i in range(30):
        delay = pacer.delay_for(i / 15, now)
        assert delay is not None
        now += delay
    assert now == pytest.approx(50 + 29 / 15)


@pytest.mark.parametrize("source_fps", [25.0, 30.0])
def test_after_a_stall_frames_are_as_near_to_their_ticks_as_before(source_fps: float) -> None:
    fps = 1 / 0.06
    pacer, now, errors = FramePacer(fps), 10.0, list[float]()
    for i in range(600):
        timestamp = i / source_fps
        now = max(now + 0.01, 10 + timestamp) + (0.61 if i in (100, 233, 391) else 0.0)
        if pacer.delay_for(timestamp, now) is not None:
            errors.append(timestamp * fps - round(timestamp * fps))
    assert len(errors) > 200 and np.abs(errors).max() / fps <= 0.5 / source_fps + 1e-6


@pytest.mark.parametrize("begin", [0.0, 0.1, 1234.56])
def test_of_two_frames_as_near_to_a_tick_the_earlier_is_sent(begin: float) -> None:
    pacer = FramePacer(1 / 0.06)
    times = [begin + i * 0.04 for i in range(10)]
    sent = [round(1000 * (time - begin)) for time in times if pacer.delay_for(time, 10 + time) is not None]
    assert sent == [0, 40, 120, 160, 240, 280, 360]


def test_late_frames_are_dropped_until_the_clip_has_caught_up() -> None:
    pacer = FramePacer(15)
    assert pacer.delay_for(0.0, 10.0) == 0
    stall = 1.0
    sent = [i for i in range(1, 60) if pacer.delay_for(i / 15, 10 + stall + i * 0.01) is not None]
    first = sent[0]
    assert 10 + stall + first * 0.01 - (10 + first / 15) <= MAX_LAG_S
    assert len(sent) == 60 - first
