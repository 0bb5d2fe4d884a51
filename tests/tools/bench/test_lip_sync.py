"""The pooled lag of lips against speech energy."""

import numpy as np
import pytest

from tools.bench.lip_sync import LAGS_S, LipSync, pooled_skew


def clip(late_s: float, seed: int) -> LipSync:
    """Return lips that move with a sound which is heard late, at 25 frames a second."""
    rng = np.random.default_rng(seed)
    loudness = np.convolve(rng.normal(size=1200), np.hanning(20), "same")  # in steps of 10 ms
    frames = np.arange(100, 1100, 4)
    shifts = np.round(100 * (LAGS_S - late_s)).astype(int)
    return LipSync(loudness[frames] + seed, loudness[frames[:, None] + shifts] - seed)


@pytest.mark.parametrize("late_s", [-0.12, 0.0, 0.05])
def test_a_shift_of_the_sound_is_found_over_all_clips(late_s: float) -> None:
    skew, correlation = pooled_skew([clip(late_s, 1), clip(late_s, 2)])
    assert skew == pytest.approx(-1000 * late_s, abs=1)
    assert correlation == pytest.approx(1.0)
