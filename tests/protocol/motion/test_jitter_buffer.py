from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, precondition, rule

from conf.protocol.messages import MotionFrame
from conf.protocol.motion.jitter_buffer import (
    EASE_S,
    FADE_S,
    HOLD_S,
    KEPT_S,
    MAX_FRAMES,
    MAX_INTERPOLATION_S,
    JitterBuffer,
    PlayoutFrame,
    eased_furrow,
)
from conf.protocol.stream_clocks import CLOCK_RESET_S, MARGIN_S, MAX_DELAY_S, OFFSET_WINDOW_S

FRAME_S = 1 / 15


def frame(timestamp: float, value: float | None = None) -> MotionFrame:
    value = timestamp if value is None else value
    return MotionFrame(timestamp, np.full((2, 3), value, dtype=np.float32), np.full(6, value))


def playout(buffer: JitterBuffer, now: float) -> PlayoutFrame:
    result = buffer.frame_at(now)
    assert result is not None
    return result


def played(buffer: JitterBuffer, now: float) -> float:
    return float(playout(buffer, now).frame.pose[0])


@pytest.mark.slow
@given(
    st.lists(st.floats(0, 0.2), min_size=20, max_size=60),
    st.sets(st.integers(1, 60), max_size=15),
    st.floats(-1e5, 1e5),
)
def test_playback_never_runs_backwards_nor_ahead(delays: list[float], lost: set[int], clock: float) -> None:
    """Whatever is lost, late or out of order, the motion drawn is that of its time, never of a later one."""
    buffer = JitterBuffer()
    arrivals = sorted((clock + i * FRAME_S + delay, i * FRAME_S) for i, delay in enumerate(delays) if i not in lost)
    shown: list[float] = []
    for (now, timestamp), (until, _) in zip(arrivals, [*arrivals[1:], (arrivals[-1][0] + 0.3, 0)], strict=True):
        buffer.add(frame(timestamp), now)
        for tick in np.arange(now, until, 0.02):
            result = buffer.frame_at(float(tick))
            if result is not None:
                shown.append(float(result.frame.pose[0]))
                assert shown[-1] <= tick - clock + 1e-6
    assert all(a <= b + 1e-9 for a, b in pairwise(shown))


@pytest.mark.parametrize(
    ("gap_s", "at", "value"),
    [
        (0.1, 0.0, 10.0),
        (0.1, 0.025, 12.5),
        (0.1, 0.075, 17.5),
        (0.2, 0.05, 12.5),
        (1.0, 0.5, 10.0),  # motion after a longer gap belongs to its last quarter of a second
        (1.0, 0.75, 10.0),
        (1.0, 0.8, 12.0),
        (1.0, 0.95, 18.0),
    ],
)
def test_between_two_frames_the_motion_is_interpolated(gap_s: float, at: float, value: float) -> None:
    buffer = JitterBuffer()
    buffer.add(frame(4.0, 10.0), 104.0)
    buffer.add(frame(4.0 + gap_s, 20.0), 104.0 + gap_s)
    result = playout(buffer, 104.0 + at + buffer.clock.delay_s)
    assert result.frame.timestamp == pytest.approx(4.0 + at)
    assert result.frame.pose == pytest.approx(np.full(6, value))
    assert result.frame.displacements == pytest.approx(np.full((2, 3), value), rel=1e-6)
    assert (result.age_s, result.neutral_blend) == (0.0, 0.0) and MAX_INTERPOLATION_S == 0.25


def test_one_loss_does_not_stop_playout() -> None:
    buffer = JitterBuffer()
    for i in range(60):
        if i != 30:
            buffer.add(frame(i * FRAME_S), i * FRAME_S)
        shown = played(buffer, i * FRAME_S + 0.9 * FRAME_S)
    assert shown == pytest.approx(59 * FRAME_S, abs=1e-6)
    assert buffer.late == 0


def test_nothing_is_played_before_the_first_frame_is_due() -> None:
    buffer = JitterBuffer()
    assert buffer.frame_at(5.0) is None and buffer.newest is None
    buffer.add(frame(3.0), 10.0)
    assert buffer.clock.delay_s == MARGIN_S and buffer.newest == 3.0
    assert buffer.frame_at(10.0 + MARGIN_S - 0.001) is None
    assert played(buffer, 10.0 + MARGIN_S + 0.001) == 3.0


def test_the_playout_delay_follows_the_lateness_up_at_once_and_down_by_a_fiftieth() -> None:
    buffer = JitterBuffer()
    buffer.add(frame(0.0), 0.0)
    buffer.add(frame(1.0), 1.2)
    assert buffer.clock.delay_s == pytest.approx(MARGIN_S), "2 % of the frames may be late"
    buffer = JitterBuffer()
    for i in range(2):
        buffer.add(frame(i * 0.1), 10.0 + i * 0.1)
    for i in range(2, 97):
        buffer.add(frame(i * 0.1), 10.3 + i * 0.1)
    assert buffer.clock.delay_s == pytest.approx(0.3 + MARGIN_S)
    buffer.add(frame(20.0), 30.3)  # after a pause only this frame is in the window
    assert buffer.clock.delay_s == pytest.approx(0.3 + MARGIN_S - 0.02 * 0.3)


def test_the_playout_delay_is_bounded() -> None:
    buffer = JitterBuffer()
    rng = np.random.default_rng(1)
    for i in range(300):
        now = i * FRAME_S
        buffer.add(frame(now), now + rng.uniform(0, 0.1))
    assert 0.08 < buffer.clock.delay_s < 0.13
    for i in range(300, 340):
        buffer.add(frame(i * FRAME_S), i * FRAME_S + 5)
    assert buffer.clock.delay_s == MAX_DELAY_S


def test_a_frame_after_its_deadline_is_late_and_one_received_twice_is_stored_once() -> None:
    buffer = JitterBuffer()
    for timestamp in (0.0, 0.1, 0.3):
        buffer.add(frame(timestamp), 10 + timestamp)
    buffer.add(frame(0.2), 10.3)
    buffer.add(frame(0.3, 99.0), 10.3)
    assert buffer.late == 0
    assert played(buffer, 10.3 + buffer.clock.delay_s) == pytest.approx(0.3)
    buffer.add(frame(0.15), 10.4)
    buffer.playhead = 0.3
    buffer.add(frame(0.3), 10.4)
    buffer.add(frame(0.4), 10.45)
    assert buffer.late == 2
    assert [f.timestamp for f in buffer._frames] == pytest.approx([0.0, 0.1, 0.15, 0.2, 0.3, 0.4])


@pytest.mark.parametrize(
    ("age_s", "blend"),
    [(0.1, 0.0), (HOLD_S, 0.0), (HOLD_S + 0.25 * FADE_S, 0.15625), (HOLD_S + FADE_S, 1.0), (9.0, 1.0)],
)
def test_without_new_frames_the_face_holds_and_then_fades_to_neutral(age_s: float, blend: float) -> None:
    buffer = JitterBuffer()
    buffer.add(frame(7.0, 4.0), 100.0)
    result = playout(buffer, 100.0 + buffer.clock.delay_s + age_s)
    assert result.age_s == pytest.approx(age_s) and result.neutral_blend == pytest.approx(blend)
    assert result.frame.timestamp == pytest.approx(7.0 + age_s)
    assert result.frame.displacements == pytest.approx(np.full((2, 3), 4 * (1 - blend)))
    assert result.frame.pose == pytest.approx(np.full(6, 4.0)), "the head stays where it is"


def test_a_still_face_is_not_a_lost_one() -> None:
    buffer = JitterBuffer()
    buffer.repeat_until(1.0, 99.0)
    assert buffer.newest is None
    buffer.add(frame(0.0, 4.0), 100.0)
    buffer.repeat_until(5.0, 105.0)
    buffer.repeat_until(4.0, 105.0)
    assert buffer.newest == 5.0 and len(buffer._frames) == 2
    result = playout(buffer, 105.0 + buffer.clock.delay_s)
    assert result.neutral_blend == 0 and result.frame.displacements[0, 0] == 4


def test_the_offset_follows_the_sender_s_clock_after_ten_seconds() -> None:
    buffer = JitterBuffer()
    buffer.add(frame(0.0), 100.0)
    buffer.add(frame(9.0), 109.2)
    assert buffer.clock._offset == 100.0
    buffer.add(frame(9.8), 100.0 + OFFSET_WINDOW_S)
    assert buffer.clock._offset == 100.0
    buffer.add(frame(9.9), 100.1 + OFFSET_WINDOW_S)
    assert buffer.clock._offset == pytest.approx(100.2)


@pytest.mark.parametrize(("jump_s", "is_reset"), [(CLOCK_RESET_S - 0.1, False), (CLOCK_RESET_S + 0.1, True)])
@pytest.mark.parametrize("sign", [-1, 1])
def test_a_clock_that_jumps_by_half_a_minute_has_started_again(jump_s: float, is_reset: bool, sign: int) -> None:
    buffer = JitterBuffer()
    buffer.add(frame(1000.0), 10.0)
    playout(buffer, 10.1)
    buffer.add(frame(1002.0 + sign * jump_s), 12.0)
    assert (len(buffer._frames) == 1) == is_reset
    if is_reset:
        assert buffer.playhead == -np.inf and buffer.late == 0
        assert played(buffer, 12.001 + buffer.clock.delay_s) == 1002.0 + sign * jump_s


def test_a_jump_of_exactly_half_a_minute_is_no_new_start() -> None:
    buffer = JitterBuffer()
    for at in range(4):
        buffer.add(frame(at), at)
        playout(buffer, at + 0.5)
    playhead = buffer.playhead
    buffer.add(frame(4.0), 4.0 + CLOCK_RESET_S)
    assert buffer.playhead == playhead


def test_repeating_up_to_the_newest_frame_or_before_changes_nothing() -> None:
    buffer = JitterBuffer()
    buffer.repeat_until(1.0, 5.0)
    assert buffer.newest is None
    buffer.add(frame(1.0), 1.0)
    before = buffer.clock.delay_s
    for timestamp in (0.5, 1.0):
        buffer.repeat_until(timestamp, 1.4)
    assert (buffer.newest, buffer.clock.delay_s, buffer.late) == (1.0, before, 0)


@pytest.mark.slow
def test_memory_is_bounded() -> None:
    buffer = JitterBuffer()
    for i in range(5 * MAX_FRAMES):
        buffer.add(frame(i * 1e-3), 0.0)
    assert len(buffer._frames) == MAX_FRAMES and buffer.newest == pytest.approx((5 * MAX_FRAMES - 1) * 1e-3)
    buffer = JitterBuffer()
    for i in range(100):
        buffer.add(frame(i * 0.1), 10 + i * 0.1)
    playout(buffer, 19.95 + buffer.clock.delay_s)
    assert [f.timestamp for f in buffer._frames[:2]] == pytest.approx([9.9 - KEPT_S, 10.0 - KEPT_S])


class Playout(RuleBasedStateMachine):
    """Frames that arrive at arbitrary times, in arbitrary order, and a receiver that draws in between."""

    def __init__(self) -> None:
        super().__init__()
        self.buffer = JitterBuffer()
        self.now = 1000.0
        self.number = 0
        self.waiting: list[int] = []
        self.late = 0
        self.drawn: list[float] = []

    @initialize(clock=st.floats(-1e4, 1e4))
    def set_clock(self, clock: float) -> None:
        self.began = self.now + clock

    @rule(steps=st.integers(1, 40))
    def capture(self, steps: int) -> None:
        self.waiting += range(self.number, self.number + min(steps, 3))
        self.number += steps
        self.now += steps * FRAME_S

    @precondition(lambda self: self.waiting)
    @rule(data=st.data(), is_lost=st.booleans())
    def arrive(self, data: st.DataObject, is_lost: bool) -> None:
        number = self.waiting.pop(data.draw(st.integers(0, len(self.waiting) - 1)))
        if not is_lost:
            self._add(number * FRAME_S, lambda: self.buffer.add(frame(number * FRAME_S), self.now))

    @rule()
    def keep_alive(self) -> None:
        newest = self.buffer.newest
        timestamp = self.number * FRAME_S
        if newest is not None and timestamp > newest:
            self._add(timestamp, lambda: self.buffer.repeat_until(timestamp, self.now))

    def _add(self, timestamp: float, add: object) -> None:
        is_late = timestamp <= self.buffer.playhead
        add()  # type: ignore[operator]
        if self.buffer.playhead > -np.inf:
            self.late += is_late

    @rule(step=st.floats(0.001, 3.0))
    def draw(self, step: float) -> None:
        self.now += step
        self.number += int(step / FRAME_S)
        result = self.buffer.frame_at(self.now)
        if result is None:
            return
        self.drawn.append(result.frame.timestamp)
        assert result.frame.timestamp == pytest.approx(self.buffer.playhead)
        newest = self.buffer.newest
        assert newest is not None
        assert result.age_s == pytest.approx(max(0.0, self.buffer.playhead - newest), abs=1e-6)
        assert 0 <= result.neutral_blend <= 1
        assert result.frame.pose[0] <= newest

    @invariant()
    def playout_time_never_goes_back(self) -> None:
        assert all(a <= b for a, b in pairwise(self.drawn))

    @invariant()
    def late_frames_are_counted(self) -> None:
        assert self.buffer.late == self.late

    @invariant()
    def depth_and_delay_are_bounded_and_frames_are_in_order(self) -> None:
        timestamps = [f.timestamp for f in self.buffer._frames]
        assert len(timestamps) <= MAX_FRAMES and timestamps == sorted(set(timestamps))
        assert self.buffer.clock.delay_s <= MAX_DELAY_S


TestPlayout = pytest.mark.slow(Playout.TestCase)
TestPlayout.settings = settings(max_examples=30, stateful_step_count=40)


def test_furrows_are_eased_from_level_to_level() -> None:
    frames = [replace(frame(0.0), furrow=0.2), replace(frame(3.0), furrow=1.0)]
    assert eased_furrow(frames[:1], 2.9) == pytest.approx(0.2), "a gap is no slow change"
    for part in (0.0, 0.25, 0.5, 1.0, 9.0):
        assert eased_furrow(frames, 3.0 + part * EASE_S) == pytest.approx(0.2 + 0.8 * min(part, 1.0))


@given(st.lists(st.tuples(st.floats(0.01, 0.3), st.floats(0, 1)), min_size=1, max_size=30), st.floats(0, 1))
def test_eased_furrows_lie_between_those_of_the_frames(steps: list[tuple[float, float]], after: float) -> None:
    times = np.cumsum([step for step, _ in steps]).tolist()
    frames = [replace(frame(time), furrow=furrow) for time, (_, furrow) in zip(times, steps, strict=True)]
    furrows = [furrow for _, furrow in steps]
    assert min(furrows) - 1e-9 <= eased_furrow(frames, times[-1] + after) <= max(furrows) + 1e-9


def test_furrows_are_played_out_and_fade_with_the_face() -> None:
    buffer = JitterBuffer()
    for number in range(8):
        buffer.add(replace(frame(number * FRAME_S), furrow=1.0), 100 + number * FRAME_S)
    end = 100 + 7 * FRAME_S + buffer.clock.delay_s
    assert playout(buffer, end).frame.furrow == pytest.approx(1.0)
    assert playout(buffer, end + HOLD_S + FADE_S / 2).frame.furrow == pytest.approx(0.5)
    assert playout(buffer, end + HOLD_S + FADE_S).frame.furrow == 0
