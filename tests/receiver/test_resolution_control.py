from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.receiver.resolution_control import (
    MAX_DRAW_S,
    MIN_SCALE,
    RAISE_AFTER,
    RETRY_AFTER,
    STEPS,
    WINDOW,
    ResolutionControl,
)


def scales(control: ResolutionControl, fixed_ms: float, full_ms: float, frames: int) -> list[float]:
    """Return the scale after each frame of a machine: fixed_ms for vertices, full_ms for all pixels at scale 1."""
    return [control.on_frame((fixed_ms + full_ms * control.scale**2) / 1000) for _ in range(frames)]


@pytest.mark.parametrize(
    ("fixed_ms", "full_ms", "expected"),
    [
        (1.0, 1.0, 1.0),  # a GPU
        (4.0, 12.0, 1.0),  # 60 frames a second
        (5.0, 21.5, 1.0),  # 37 frames a second
        (5.0, 25.0, 14 / 16),
        (6.0, 40.0, 11 / 16),
        (8.0, 60.0, 9 / 16),
        (10.0, 120.0, MIN_SCALE),
        (60.0, 60.0, MIN_SCALE),  # nine callers: the vertices alone take too long
        (33.3, 0.0, 1.0),  # a display of 30 Hz, for which the driver waits
        (40.0, 3.0, 1.0),
    ],
)
def test_the_scale_settles_where_drawing_takes_less_than_the_limit(
    fixed_ms: float, full_ms: float, expected: float
) -> None:
    settled = scales(ResolutionControl(), fixed_ms, full_ms, 20 * RAISE_AFTER)[-5 * RAISE_AFTER :]
    assert set(settled) == {expected}
    if MIN_SCALE < expected < 1.0:
        assert fixed_ms + full_ms * expected**2 <= MAX_DRAW_S * 1000


@pytest.mark.slow
@given(st.floats(1.0, 20.0), st.floats(0.0, 200.0))
def test_the_scale_does_not_oscillate_on_any_machine(fixed_ms: float, full_ms: float) -> None:
    settled = scales(ResolutionControl(), fixed_ms, full_ms, 40 * RAISE_AFTER)[-20 * RAISE_AFTER :]
    assert len(set(settled)) == 1


@pytest.mark.slow
@given(st.integers(0, 2**32 - 1), st.floats(2.0, 16.6))
def test_a_machine_that_draws_sixty_frames_a_second_keeps_the_full_resolution(seed: int, draw_ms: float) -> None:
    """Every fourth frame takes five times as long: another program runs."""
    control, rng = ResolutionControl(), np.random.default_rng(seed)
    for frame in range(300):
        control.on_frame(draw_ms / 1000 * (5 if frame % 4 == 0 else rng.uniform(0.9, 1.0)))
    assert control.scale == 1.0


def test_the_first_slow_frames_change_nothing() -> None:
    control = ResolutionControl()
    for draw_s in [0.9, 0.4, *[0.01] * 60]:
        assert control.on_frame(draw_s) == 1.0


def test_the_scale_falls_at_once_and_rises_step_by_step() -> None:
    control = ResolutionControl()
    falling = scales(control, 4.0, 100.0, WINDOW)
    assert falling[-2:] == [1.0, pytest.approx(0.5, abs=0.07)]
    rising = scales(control, 4.0, 8.0, 20 * RAISE_AFTER)
    assert rising[-1] == 1.0
    steps = [b - a for a, b in pairwise(rising) if b != a]
    assert set(steps) == {1 / STEPS}
    assert rising.count(control.scale - 1 / STEPS) >= RAISE_AFTER


def test_a_fall_that_did_not_help_is_undone_and_tried_again_later() -> None:
    control = ResolutionControl()
    tried = scales(control, 40.0, 1.0, RETRY_AFTER + 3 * WINDOW)
    lower = [frame for frame, scale in enumerate(tried) if scale < 1.0]
    assert lower[0] < WINDOW and lower[WINDOW] > RETRY_AFTER and len(lower) <= 2 * WINDOW
