import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.sender.motion.one_euro_filter import MAX_GAP, OneEuroFilter


@given(st.floats(-100, 100), st.floats(10, 120))
def test_a_constant_stays_as_it_is(value: float, fps: float) -> None:
    smooth = OneEuroFilter(min_cutoff=1.0, beta=0.5)
    for i in range(20):
        assert smooth.smooth(np.array([value]), i / fps) == pytest.approx(value)


@given(st.lists(st.floats(-10, 10), min_size=2, max_size=40))
def test_nothing_leaves_the_range_of_what_came_in(values: list[float]) -> None:
    smooth = OneEuroFilter(min_cutoff=1.0, beta=3.0)
    for i, value in enumerate(values):
        out = smooth.smooth(np.array([value]), i / 25).item()
        assert min(values) - 1e-9 <= out <= max(values) + 1e-9


def test_noise_on_a_still_value_shrinks_and_a_jump_gets_through() -> None:
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


def test_the_same_motion_at_another_frame_rate_is_smoothed_alike() -> None:
    def at(fps: int) -> float:
        smooth = OneEuroFilter(min_cutoff=0.5, beta=0.0)
        return [smooth.smooth(np.array([min(i / fps, 1.0)]), i / fps).item() for i in range(2 * fps + 1)][-1]

    assert at(120) == pytest.approx(at(60), abs=0.01)


@pytest.mark.parametrize("time", [10 + MAX_GAP * 1.01, 10.0, 9.0])
def test_after_a_pause_or_a_step_back_in_time_the_past_is_forgotten(time: float) -> None:
    smooth = OneEuroFilter(min_cutoff=0.1, beta=0.0)
    smooth.smooth(np.array([0.0]), 10.0)
    assert smooth.smooth(np.array([5.0]), time).item() == 5.0


def test_reset_forgets() -> None:
    smooth = OneEuroFilter(min_cutoff=0.1, beta=0.0)
    smooth.smooth(np.array([0.0]), 0.0)
    smooth.reset()
    assert smooth.smooth(np.array([5.0]), 0.04).item() == 5.0


@pytest.mark.parametrize(("min_cutoff", "beta"), [(0.0, 1.0), (-1.0, 1.0), (1.0, -0.1)])
def test_impossible_settings_are_refused(min_cutoff: float, beta: float) -> None:
    with pytest.raises(ValueError, match=r"^min_cutoff must be positive and beta must not be negative$"):
        OneEuroFilter(min_cutoff=min_cutoff, beta=beta)
