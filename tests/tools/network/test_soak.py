"""A call of twelve seconds with tools/network/soak.py: two processes and a lossy link."""

from pathlib import Path

import numpy as np
import pytest

from conf.commands.extract import extract
from conf.output.wav_writer import write_wav
from tools.network.impair import Faults
from tools.network.soak import ROWS, call, call_of_two, figures, latency, longest_stall


@pytest.mark.slow
def test_a_call_over_a_lossy_link_neither_grows_nor_stalls(carphone_clip: Path) -> None:
    result = figures(*call(carphone_clip, 12.0, Faults(loss=0.05, delay_ms=20, jitter_ms=10)))
    assert len(result["rows"]) == ROWS
    assert result["frames_received"] > 0.6 * result["frames_sent"] > 30
    assert result["longest_stall_s"] < 3.0
    assert abs(result["receiver_growth_kb"]) < 30_000


@pytest.mark.slow
def test_a_call_of_two_has_figures_of_both_directions(carphone_clip: Path, tmp_path: Path) -> None:
    motion, sound = tmp_path / "motion.dpc", tmp_path / "sound.wav"
    extract(carphone_clip, motion)
    tone = 8000 * np.sin(np.arange(16000 * 4) * 0.1) * (np.arange(16000 * 4) % 8000 < 5000)
    write_wav(sound, tone.astype(np.int16), rate=16000)
    calling, called = call_of_two(motion, sound, 10.0, Faults(loss=0.05, delay_ms=20), options=["--speaker", "null"])
    for sent, received in ((calling, called), (called, calling)):
        result = figures(sent, received, rows=2)
        assert result["frames_received"] > 0.5 * result["frames_sent"] > 20
        assert result["longest_stall_s"] < 3.0
        assert result["rows"][1]["concealed_ms"] < 3000
        assert {line["calls"] for line in received} <= {0, 1}


def test_latency_is_the_time_from_a_capture_to_its_image() -> None:
    captures = [[10.0 + i / 10, 3.0 + i / 10] for i in range(50)]
    images = [[10.25 + i / 30, i / 30, 0.0] for i in range(100)]
    assert latency(captures, images) == pytest.approx(0.25)


def test_a_stall_begins_with_the_first_frame_that_is_missing() -> None:
    images = [[20.0 + i / 10, i / 10, max(0.0, i / 10 - 1.0)] for i in range(30)]  # nothing arrives after 1.0
    assert longest_stall([0.5, 1.0, 1.7, 2.0], images) == pytest.approx(2.9 - 1.7)
    assert longest_stall([0.5, 1.0], images) == 0.0, "a face that holds still does not stall"
