"""The format of sound: rounding, levels, times."""

import numpy as np
import pytest

from conf.audio.samples import SILENCE_DBFS, AudioBlock, amplitude, level_dbfs, power_dbfs, to_int16
from tests.support.synthetic_voice import noise, tone


def test_a_block_ends_where_the_next_begins() -> None:
    assert AudioBlock(2.0, np.zeros(320, np.int16)).end == pytest.approx(2.02)


def test_samples_are_rounded_and_clipped() -> None:
    assert to_int16(np.array([0.6, -1.6, 40000.0, -40000.0])).tolist() == [1, -2, 32767, -32768]
    assert to_int16(np.array([0.6])).dtype == np.int16


def test_level_of_a_sine_is_3_db_below_its_peak() -> None:
    assert level_dbfs(tone(1000, 0.1, amplitude=32767)) == pytest.approx(-3.01, abs=0.01)
    assert level_dbfs(tone(1000, 0.1, amplitude=3276.7)) == pytest.approx(-23.01, abs=0.01)


def test_level_of_silence_is_the_floor() -> None:
    assert power_dbfs(0.0) == SILENCE_DBFS and power_dbfs(1.0) == 0.0
    assert level_dbfs(np.zeros(100, np.int16)) == level_dbfs(np.zeros(0, np.int16)) == SILENCE_DBFS


@pytest.mark.parametrize("dbfs", [-60.0, -40.0, -20.0])
def test_amplitude_is_the_inverse_of_level(dbfs: float) -> None:
    assert 20 * np.log10(amplitude(dbfs) / 32768) == pytest.approx(dbfs)
    assert level_dbfs(noise(1.0, dbfs)) == pytest.approx(dbfs, abs=0.2)


def test_amplitude_of_silence_is_zero() -> None:
    assert amplitude(SILENCE_DBFS) == amplitude(-200) == 0.0
