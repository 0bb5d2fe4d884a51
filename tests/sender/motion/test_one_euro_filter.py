import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.sender.motion.one_euro_filter import OneEuroFilter


class ReferenceFilter:
    """The filter of one number, written from the paper: alpha = 1 / (1 + tau / Te), tau = 1 / (2 pi fc)."""

    def __init__(self, min_cutoff: float, beta: float) -> None:
        self.min_cutoff, self.beta = min_cutoff, beta
        self.time = self.value = math.nan
        self.speed = 0.0

    def smooth(self, value: float, time: float) -> float:
        if math.isnan(self.time):
            self.time, self.value = time, value
            return value
        elapsed = time - self.time
        speed = (value - self.value) / elapsed
        self.speed += (speed - self.speed) / (1 + 1 / (2 * math.pi * 1.0 * elapsed))
        cutoff = self.min_cutoff + self.beta * abs(self.speed)
        self.value += (value - self.value) / (1 + 1 / (2 * math.pi * cutoff * elapsed))
        self.time = time
        return self.value


@pytest.mark.slow
@given(
    st.lists(st.tuples(st.floats(-10, 10), st.floats(0.005, 0.45)), min_size=2, max_size=30),
    st.floats(0.1, 10),
    st.floats(0, 10),
)
def test_values_are_those_of_the_paper(steps: list[tuple[float, float]], min_cutoff: float, beta: float) -> None:
    ours, reference, now = OneEuroFilter(min_cutoff=min_cutoff, beta=beta), ReferenceFilter(min_cutoff, beta), 3.0
    for value, elapsed in steps:
        now += elapsed
        assert ours.smooth(np.array([value]), now).item() == pytest.approx(reference.smooth(value, now), abs=1e-9)


@pytest.mark.parametrize("dtype", [np.float64, np.float32, np.int64])
def test_a_moving_value_is_that_of_the_paper_in_float64(dtype: type[np.generic]) -> None:
    ours, reference = OneEuroFilter(min_cutoff=1, beta=2), ReferenceFilter(1.0, 2.0)
    for i, value in enumerate(np.random.default_rng(5).integers(-50, 50, 40).tolist()):
        smoothed = ours.smooth(np.array([value], dtype=dtype), 3 + i / 30)
        assert smoothed.dtype == np.float64
        assert smoothed.item() == pytest.approx(reference.smooth(value, 3 + i / 30), abs=1e-9)


@pytest.mark.slow
@given(st.floats(-100, 100), st.floats(10, 120))
def test_a_constant_is_unchanged(value: float, fps: float) -> None:
    smooth = OneEuroFilter(min_cutoff=1.0, beta=0.5)
    for i in range(20):
        assert smooth.smooth(np.array([value]), i / fps) == pytest.approx(value)


@pytest.mark.slow
@given(st.lists(st.floats(-10, 10), min_size=2, max_size=40))
def test_outputs_stay_within_the_range_of_the_inputs(values: list[float]) -> None:
    smooth = OneEuroFilter(min_cutoff=1.0, beta=3.0)
    for i, value in enumerate(values):
        out = smooth.smooth(np.array([value]), i / 25).item()
        assert min(values) - 1e-9 <= out <= max(values) + 1e-9


def test_noise_is_reduced_and_a_jump_passes() -> None:
    noise = np.random.default_rng(0).normal(scale=0.01, size=300)
    smooth = OneEuroFilter(min_cutoff=1.0, beta=5.0)
    still = [smooth.smooth(np.array([x]), i / 30).item() for i, x in enumerate(noise)]
    assert np.std(still[30:]) < 0.5 * np.std(noise[30:])
    jump = [smooth.smooth(np.array([10.0 + x]), 10 + i / 30).item() for i, x in enumerate(noise[:6])]
    assert jump[3] > 9.5


def test_each_value_has_its_own_filter() -> None:
    together = OneEuroFilter(min_cutoff=np.array([1.0, 8.0]), beta=np.array([0.0, 2.0]))
    apart = [OneEuroFilter(min_cutoff=1.0, beta=0.0), OneEuroFilter(min_cutoff=8.0, beta=2.0)]
    for i, pair in enumerate(np.random.default_rng(1).normal(size=(30, 2))):
        expected = [one.smooth(x, i / 25) for one, x in zip(apart, pair, strict=True)]
        assert np.allclose(together.smooth(pair, i / 25), expected)


@pytest.mark.parametrize(
    ("time", "starts_again"), [(10.5, False), (10.501, True), (10.0, True), (9.0, True), (10.001, False)]
)
def test_the_filter_starts_again_after_half_a_second_or_a_step_back(time: float, starts_again: bool) -> None:
    smooth = OneEuroFilter(min_cutoff=0.1, beta=0.0)
    smooth.smooth(np.array([0.0]), 10.0)
    assert (smooth.smooth(np.array([5.0]), time).item() == 5.0) == starts_again
    reference = ReferenceFilter(0.1, 0.0)
    if starts_again:  # then the speed is 0 and the next time is counted from here
        reference.smooth(5.0, time)
        assert smooth.smooth(np.array([6.0]), time + 0.1).item() == pytest.approx(reference.smooth(6.0, time + 0.1))


def test_after_a_restart_the_speed_is_zero() -> None:
    smooth, fresh = (OneEuroFilter(min_cutoff=1.0, beta=5.0) for _ in range(2))
    for i in range(10):
        smooth.smooth(np.array([float(i)]), i / 25)
    smooth.reset()
    for i in range(3):
        assert smooth.smooth(np.array([i / 10]), 1 + i / 25) == fresh.smooth(np.array([i / 10]), 1 + i / 25)


def test_the_first_value_is_returned_unchanged_at_any_time() -> None:
    for time in (0.0, 0.04, -5.0, 1e9):
        assert OneEuroFilter(min_cutoff=0.1, beta=0.0).smooth(np.array([5.0]), time).item() == 5.0


def test_reset_starts_again() -> None:
    smooth = OneEuroFilter(min_cutoff=0.1, beta=0.0)
    smooth.smooth(np.array([0.0]), 0.0)
    smooth.reset()
    assert smooth.smooth(np.array([5.0]), 0.04).item() == 5.0


@pytest.mark.parametrize(("min_cutoff", "beta"), [(0.0, 1.0), (-1.0, 1.0), (1.0, -0.1), ([1.0, 0.0], 1.0)])
def test_invalid_parameters_are_refused(min_cutoff: float, beta: float) -> None:
    with pytest.raises(ValueError, match=r"^min_cutoff must be positive and beta must not be negative$"):
        OneEuroFilter(min_cutoff=min_cutoff, beta=beta)
