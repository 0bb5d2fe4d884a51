"""A call of twelve seconds with tools/network/soak.py: two processes and a lossy link."""

from pathlib import Path

import pytest

from tools.network.impair import Faults
from tools.network.soak import ROWS, call, figures, latency


@pytest.mark.slow
def test_a_call_over_a_lossy_link_neither_grows_nor_stalls(carphone_clip: Path) -> None:
    result = figures(*call(carphone_clip, 12.0, Faults(loss=0.05, delay_ms=20, jitter_ms=10)))
    assert len(result["rows"]) == ROWS
    assert result["frames_received"] > 0.6 * result["frames_sent"] > 30
    assert result["longest_stall_s"] < 3.0
    assert abs(result["receiver_growth_kb"]) < 30_000


def test_latency_is_the_time_from_a_capture_to_its_image() -> None:
    captures = [[10.0 + i / 10, 3.0 + i / 10] for i in range(50)]
    images = [[10.25 + i / 30, i / 30, 0.0] for i in range(100)]
    assert latency(captures, images) == pytest.approx(0.25)
