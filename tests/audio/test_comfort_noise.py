"""Noise in pauses: its level, its spectrum, no seams, off when there is none."""

import numpy as np
import pytest

from conf.audio.comfort_noise import ComfortNoise
from conf.audio.samples import SILENCE_DBFS, level_dbfs
from tests.support.synthetic_voice import max_jump


def generator(seed: int = 0) -> ComfortNoise:
    return ComfortNoise(np.random.default_rng(seed))


@pytest.mark.parametrize("dbfs", [-70.0, -50.0, -30.0])
def test_the_level_is_the_one_asked(dbfs: float) -> None:
    noise = generator()
    noise.generate(3200, dbfs)
    assert level_dbfs(noise.generate(16000, dbfs)) == pytest.approx(dbfs, abs=0.5)


def test_high_frequencies_are_weaker() -> None:
    samples = generator().generate(32000, -40.0)
    power = np.abs(np.fft.rfft(samples)) ** 2  # 0.5 Hz a bin
    assert 30 * power[8000:16000].mean() < power[200:1000].mean()


def test_silence_turns_it_off_gradually() -> None:
    noise = generator()
    noise.generate(3200, -40.0)
    levels = [level_dbfs(noise.generate(160, SILENCE_DBFS)) for _ in range(20)]
    assert levels[0] > -48
    assert levels[-1] == SILENCE_DBFS
    assert not generator().generate(320, SILENCE_DBFS).any()


def test_it_starts_without_a_click() -> None:
    noise = generator()
    noise.generate(160, SILENCE_DBFS)
    start = noise.generate(1600, -30.0)
    assert abs(int(start[0])) < 0.1 * np.abs(start[800:]).max()


def test_blocks_have_no_seams() -> None:
    whole, parts = generator(4), generator(4)
    expected = whole.generate(16000, -30.0)
    joined = np.concatenate([parts.generate(count, -30.0) for count in (0, 160, 1, 39, 800, 15000)])
    assert max_jump(joined) < 1.3 * max_jump(expected)
    assert level_dbfs(joined[1000:]) == pytest.approx(-30.0, abs=0.5)


def test_no_samples() -> None:
    assert len(generator().generate(0, -40.0)) == 0
