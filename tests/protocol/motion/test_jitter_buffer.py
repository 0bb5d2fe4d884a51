from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.protocol.messages import MotionFrame
from conf.protocol.motion.jitter_buffer import EASE_S, HOLD_S, MAX_DELAY_S, MAX_FRAMES, JitterBuffer

FRAME_S = 1 / 15


def frame(timestamp: float, value: float | None = None) -> MotionFrame:
    value = timestamp if value is None else value
    return MotionFrame(timestamp, np.full((2, 3), value, dtype=np.float32), np.full(6, value))


def played(buffer: JitterBuffer, now: float) -> float:
    playout = buffer.play(now)
    assert playout is not None
    return float(playout.frame.pose[0])


@given(
    st.lists(st.floats(0, 0.2), min_size=20, max_size=60),
    st.sets(st.integers(1, 60), max_size=15),
    st.floats(-1e5, 1e5),
)
def test_playback_never_runs_backwards_nor_ahead(delays: list[float], lost: set[int], clock: float) -> None:
    """Whatever is lost, late or out of order, the picture shown is the motion of its time, never of a later one."""
    buffer = JitterBuffer()
    arrivals = sorted((clock + i * FRAME_S + delay, i * FRAME_S) for i, delay in enumerate(delays) if i not in lost)
    shown: list[float] = []
    for (now, timestamp), (until, _) in zip(arrivals, [*arrivals[1:], (arrivals[-1][0] + 0.3, 0)], strict=True):
        buffer.add(frame(timestamp), now)
        for tick in np.arange(now, until, 0.02):
            playout = buffer.play(float(tick))
            if playout is not None:
                shown.append(float(playout.frame.pose[0]))
                assert shown[-1] <= tick - clock + 1e-6
    assert all(a <= b + 1e-9 for a, b in pairwise(shown))


def test_one_loss_does_not_stop_playout() -> None:
    buffer = JitterBuffer()
    for i in range(60):
        if i != 30:
            buffer.add(frame(i * FRAME_S), i * FRAME_S)
        shown = played(buffer, i * FRAME_S + 0.9 * FRAME_S)
    assert shown == pytest.approx(59 * FRAME_S, abs=1e-6)
    assert buffer.late == 0


def test_delay_follows_jitter_up_at_once_and_down_slowly() -> None:
    buffer = JitterBuffer()
    rng = np.random.default_rng(1)
    now = 0.0
    for i in range(300):
        now = i * FRAME_S
        buffer.add(frame(now), now + rng.uniform(0, 0.1))
    jittery = buffer.playout_delay_s
    assert 0.08 < jittery < 0.13
    for i in range(300, 900):
        now = i * FRAME_S
        buffer.add(frame(now), now)
    assert buffer.playout_delay_s < 0.03
    buffer.add(frame(now + FRAME_S), now + 20)
    assert buffer.playout_delay_s <= MAX_DELAY_S


def test_silence_holds_then_eases_to_neutral() -> None:
    buffer = JitterBuffer()
    buffer.add(frame(0.0, 4.0), 100.0)
    due = 100.0 + buffer.playout_delay_s
    held, eased = buffer.play(due + HOLD_S * 0.9), buffer.play(due + HOLD_S + EASE_S)
    assert held is not None and eased is not None
    assert held.neutral_blend == 0 and held.frame.displacements[0, 0] == 4
    assert eased.neutral_blend == 1 and not eased.frame.displacements.any()
    assert eased.age_s == pytest.approx(HOLD_S + EASE_S)


def test_a_still_face_is_not_a_lost_one() -> None:
    buffer = JitterBuffer()
    buffer.add(frame(0.0, 4.0), 100.0)
    buffer.repeat_until(5.0, 105.0)
    playout = buffer.play(105.0 + buffer.playout_delay_s)
    assert playout is not None and playout.neutral_blend == 0 and playout.frame.displacements[0, 0] == 4


def test_motion_after_a_still_face_belongs_to_its_end() -> None:
    buffer = JitterBuffer()
    buffer.add(frame(0.0, 0.0), 0.0)
    buffer.add(frame(2.0, 1.0), 2.0)
    assert played(buffer, 1.5 + buffer.playout_delay_s) == 0
    assert played(buffer, 2.0 + buffer.playout_delay_s) == pytest.approx(1)


def test_a_sender_that_starts_anew_is_played_at_once() -> None:
    buffer = JitterBuffer()
    buffer.add(frame(5000.0), 10.0)
    buffer.add(frame(0.0), 12.0)
    assert played(buffer, 12.001 + buffer.playout_delay_s) == 0


def test_memory_stays_bounded() -> None:
    buffer = JitterBuffer()
    for i in range(5 * MAX_FRAMES):
        buffer.add(frame(i * 1e-3), 0.0)
    assert len(buffer._frames) <= MAX_FRAMES
