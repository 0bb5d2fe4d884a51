"""What tools/bench/voice.py --json prints for a rate, and its reference without pauses."""

import numpy as np
import pytest

from conf.audio.samples import SAMPLE_RATE
from tools.bench.voice import Figures, summary, without_pauses

CLEAN = Figures(14.7, 15.2, 0.93, 0.94, 0.84, 0.79, 16.7, 43.0, 30.0)
LOSSY = Figures(14.5, 15.2, 0.87, 0.88, 0.78, 0.79, 16.7, 73.0, 30.0)


@pytest.mark.parametrize(
    ("skews", "delay_ms", "skew", "delay"), [([10.0, -30.0], 104.0, -30.0, 104.0), ([], None, None, 43.0)]
)
def test_json_has_the_figures_of_a_rate(
    skews: list[float], delay_ms: float | None, skew: float | None, delay: float
) -> None:
    assert summary(CLEAN, LOSSY, skews, delay_ms) == {
        "kbps": 14.7,
        "stoi": 0.93,
        "stoi_loss10": 0.87,
        "face_error_percent": 0.79,
        "skew_ms": skew,
        "delay_ms": delay,
        "cpu_ms_per_s": 30.0,
    }


def test_without_pauses_only_speech_is_left() -> None:
    rng = np.random.default_rng(1)
    levels = np.repeat([20.0, 3000.0, 20.0], SAMPLE_RATE)
    sound = (rng.normal(0, 1, len(levels)) * levels).astype(np.int16)
    kept = without_pauses(sound)
    assert len(kept) == len(sound)
    assert not kept[: SAMPLE_RATE * 4 // 5].any() and not kept[-SAMPLE_RATE * 4 // 5 :].any()
    np.testing.assert_array_equal(kept[SAMPLE_RATE : 2 * SAMPLE_RATE], sound[SAMPLE_RATE : 2 * SAMPLE_RATE])
