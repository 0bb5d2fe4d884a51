import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.receiver.resolution_control import (
    MAX_DRAW_S,
    MAX_INTERVAL,
    MIN_SCALE,
    RAISE_AFTER,
    RETRY_AFTER,
    STEPS,
    WINDOW,
    DrawingDetail,
    ResolutionControl,
)


def scales(control: ResolutionControl, fixed_ms: float, full_ms: float, frames: int) -> list[float]:
    """Return the scale after each frame of a machine: fixed_ms for vertices, full_ms for all pixels at scale 1."""
    return [control.on_frame((fixed_ms + full_ms * control.detail.scale**2) / 1000).scale for _ in range(frames)]


def details(
    control: ResolutionControl, times_ms: tuple[float, float, float], cells: int, frames: int
) -> list[DrawingDetail]:
    """Return the detail after each frame of a machine.

    times_ms : for panels and the window, for the vertices of a head, for the pixels of a head at scale 1
    """
    fixed, vertices, pixels = times_ms
    found = []
    for _ in range(frames):
        heads = math.ceil(cells / control.detail.interval)
        time_ms = fixed + heads * (vertices + pixels * control.detail.scale**2)
        found.append(control.on_frame(time_ms / 1000, cells=cells))
    return found


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
    assert control.detail == DrawingDetail()


def test_the_first_slow_frames_change_nothing() -> None:
    control = ResolutionControl()
    for draw_s in [0.9, 0.4, *[0.01] * 60]:
        assert control.on_frame(draw_s) == DrawingDetail()


def test_the_scale_falls_at_once_and_rises_step_by_step() -> None:
    control = ResolutionControl()
    falling = scales(control, 4.0, 100.0, WINDOW)
    assert falling[-2:] == [1.0, pytest.approx(0.5, abs=0.07)]
    rising = scales(control, 4.0, 8.0, 20 * RAISE_AFTER)
    assert rising[-1] == 1.0
    steps = [b - a for a, b in pairwise(rising) if b != a]
    assert set(steps) == {1 / STEPS}
    assert rising.count(control.detail.scale - 1 / STEPS) >= RAISE_AFTER


def test_a_fall_that_did_not_help_is_undone_and_tried_again_later() -> None:
    control = ResolutionControl()
    tried = scales(control, 40.0, 1.0, RETRY_AFTER + 3 * WINDOW)
    lower = [frame for frame, scale in enumerate(tried) if scale < 1.0]
    assert lower[0] < WINDOW and lower[WINDOW] > RETRY_AFTER and len(lower) <= 2 * WINDOW


@pytest.mark.parametrize(
    ("times_ms", "cells", "expected"),
    [
        ((1.0, 0.1, 0.1), 9, DrawingDetail()),  # a GPU
        ((4.0, 4.0, 1.5), 4, DrawingDetail()),
        ((4.0, 5.0, 2.0), 4, DrawingDetail(interval=2)),
        ((5.0, 3.0, 2.0), 9, DrawingDetail(12 / 16, 2)),
        ((5.0, 5.0, 5.0), 9, DrawingDetail(MIN_SCALE, 3)),
        ((4.0, 9.0, 6.0), 2, DrawingDetail(interval=2)),
        ((33.3, 0.0, 0.0), 4, DrawingDetail()),  # a display of 30 Hz, for which the driver waits
    ],
)
def test_of_several_heads_fewer_are_drawn_in_a_frame_before_they_are_blurred(
    times_ms: tuple[float, float, float], cells: int, expected: DrawingDetail
) -> None:
    assert set(details(ResolutionControl(), times_ms, cells, 40 * RAISE_AFTER)[-10 * RAISE_AFTER :]) == {expected}


@pytest.mark.slow
@given(st.floats(1.0, 6.0), st.floats(1.0, 12.0), st.floats(0.5, 12.0), st.integers(2, 9))
def test_the_detail_of_several_heads_does_not_oscillate_and_is_coarse_only_if_it_must(
    fixed_ms: float, vertices_ms: float, pixels_ms: float, cells: int
) -> None:
    times_ms = (fixed_ms, vertices_ms, pixels_ms)
    settled = details(ResolutionControl(), times_ms, cells, 60 * RAISE_AFTER)[-20 * RAISE_AFTER :]
    assert len(set(settled)) == 1
    if settled[0] != DrawingDetail():
        assert fixed_ms + cells * (vertices_ms + pixels_ms) > 20.0
    assert settled[0].interval <= min(cells, MAX_INTERVAL)


def test_when_callers_leave_the_last_one_is_drawn_in_every_frame() -> None:
    control = ResolutionControl()
    assert details(control, (4.0, 7.0, 6.0), 4, WINDOW)[-1] == DrawingDetail(interval=2)
    assert control.on_frame(0.03, cells=1) == DrawingDetail()
    assert details(control, (4.0, 7.0, 6.0), 1, 3 * WINDOW)[-1] == DrawingDetail()


def test_the_detail_rises_again_when_there_is_time() -> None:
    control = ResolutionControl()
    assert details(control, (4.0, 8.0, 8.0), 9, 10 * WINDOW)[-1] == DrawingDetail(MIN_SCALE, 3)
    rising = details(control, (1.0, 0.2, 0.2), 9, 20 * RAISE_AFTER)
    changes = [detail for before, detail in pairwise(rising) if before != detail]
    assert changes[0] == DrawingDetail(MIN_SCALE, 2) and changes[-1] == DrawingDetail()
    assert all(b.effort > a.effort for a, b in pairwise(changes))
