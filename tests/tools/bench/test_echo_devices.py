"""The figures of tools/bench/echo_devices.py, without sound devices."""

import numpy as np
import pytest

from conf.audio.samples import SAMPLE_RATE, AudioBlock
from tools.bench.echo_devices import _track, erle_by_second


def test_echo_return_loss_counts_from_the_first_second_with_an_echo() -> None:
    levels = np.repeat([0, 1000, 2000, 0, 1000, 0], SAMPLE_RATE)
    signs = np.where(np.arange(len(levels)) % 2, 1, -1)
    before = (levels * signs).astype(np.int16)
    figures = erle_by_second(before, before // 10)
    assert figures == [pytest.approx(20, abs=0.2), pytest.approx(20, abs=0.2), None, pytest.approx(20, abs=0.2)]


def test_blocks_are_placed_by_their_times() -> None:
    blocks = [AudioBlock(5.0, np.full(160, 1, np.int16)), AudioBlock(5.02, np.full(160, 2, np.int16))]
    track = _track(blocks, 5.0)
    assert [int(track[i]) for i in (0, 159, 160, 319, 320, 479, 480)] == [1, 1, 0, 0, 2, 2, 0]
