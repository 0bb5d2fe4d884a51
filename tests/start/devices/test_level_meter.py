import numpy as np
import pytest

from conf.start.devices.level_meter import FALL_DB_PER_S, FLOOR_DBFS, LevelMeter

NONE = np.zeros(0, np.int16)


@pytest.mark.parametrize(("amplitude", "dbfs"), [(32768 / 2, -6.02), (3277, -20.0), (0, FLOOR_DBFS), (1, FLOOR_DBFS)])
def test_the_level_is_that_of_a_square_wave(amplitude: float, dbfs: float) -> None:
    meter = LevelMeter()
    meter.update((amplitude * np.tile([1, -1], 80)).astype(np.int16), 10.0)
    assert meter.level == pytest.approx(1 - dbfs / FLOOR_DBFS, abs=0.001)


def test_a_meter_rises_at_once_and_falls_slowly_to_nothing() -> None:
    meter = LevelMeter()
    assert meter.level == 0
    meter.update(np.full(160, -32768, np.int16), 10.0)
    assert meter.level == 1
    meter.update(NONE, 10.5)
    assert meter.level == pytest.approx(1 + FALL_DB_PER_S * 0.5 / FLOOR_DBFS)
    meter.update(np.zeros(160, np.int16), 10.5)
    assert meter.level == pytest.approx(1 + FALL_DB_PER_S * 0.5 / FLOOR_DBFS)
    meter.update(NONE, 99.0)
    assert meter.level == 0
