import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.sender.frame_pacer import MAX_LAG_S, FramePacer


@given(st.floats(8, 60), st.floats(5, 30), st.floats(0, 1e6))
def test_a_source_is_thinned_to_the_rate_never_multiplied(source_fps: float, fps: float, clock: float) -> None:
    pace = FramePacer(fps)
    stamps = np.arange(0, 20, 1 / source_fps)
    sent = [s for s in stamps if pace.delay_for(float(s), clock + float(s)) is not None]
    assert len(sent) / 20 == pytest.approx(min(fps, source_fps), rel=0.02, abs=0.1)


def test_a_clip_read_ahead_is_held_back_to_its_own_speed() -> None:
    pace = FramePacer(15)
    now = 50.0
    for i in range(30):
        wait = pace.delay_for(i / 15, now)
        assert wait is not None
        now += wait
    assert now == pytest.approx(50 + 29 / 15)


def test_frames_that_are_too_late_are_dropped_until_the_clip_has_caught_up() -> None:
    pace = FramePacer(15)
    assert pace.delay_for(0.0, 10.0) == 0
    stall = 1.0
    sent = [i for i in range(1, 60) if pace.delay_for(i / 15, 10 + stall + i * 0.01) is not None]
    first = sent[0]
    assert 10 + stall + first * 0.01 - (10 + first / 15) <= MAX_LAG_S
    assert len(sent) == 60 - first
