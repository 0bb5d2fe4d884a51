"""What tools/bench/voice.py --json prints for a rate, and its reference without pauses."""

from dataclasses import replace

import numpy as np

from conf.audio.samples import SAMPLE_RATE
from tools.bench.voice import BURSTS, CLEAN, LOSS10, PLAIN, Figures, Scores, summary, without_pauses

FIGURES = Figures(14.7, 15.2, Scores(0.93, 0.94, 0.84), 0.79, 16.7, 43.0, 30.0)


def test_json_has_the_figures_of_a_rate() -> None:
    lossy = replace(
        FIGURES, kbps=14.5, worst_kbps=15.4, scores=Scores(0.87, 0.9, 0.8), face_error_percent=0.8, cpu_ms_per_s=31.0
    )
    measured = {
        CLEAN: FIGURES,
        LOSS10: lossy,
        BURSTS: replace(lossy, scores=Scores(0.85, 0.9, 0.8)),
        PLAIN[0]: replace(lossy, scores=Scores(0.88, 0.9, 0.8)),
    }
    assert summary(measured, -30.0, 104.0) == {
        "kbps": 14.7,
        "worst_kbps": 15.4,
        "stoi": 0.93,
        "stoi_loss5": None,
        "stoi_loss10": 0.87,
        "stoi_loss20": None,
        "stoi_bursts10": 0.85,
        "stoi_plain5": 0.88,
        "stoi_plain20": None,
        "face_error_percent": 0.79,
        "face_fps": 16.7,
        "skew_ms": -30.0,
        "delay_ms": 104.0,
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
