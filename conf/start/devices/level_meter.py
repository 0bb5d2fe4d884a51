"""The level of a sound as a meter shows it."""

import math

import numpy as np

from conf.audio.samples import Samples

FLOOR_DBFS = -60.0  # of a meter that shows nothing; quiet rooms are below
FALL_DB_PER_S = 24.0  # IEC 60268-10 type I: 20 dB in 1.7 s is slow for speech; twice as fast
_FULL_SCALE = 32768.0


class LevelMeter:
    """Rises at once, falls slowly."""

    def __init__(self) -> None:
        self._dbfs = FLOOR_DBFS
        self._updated = 0.0

    def update(self, samples: Samples, now: float, /) -> None:
        """Use the newest samples, which may be none. now : s"""
        fallen = self._dbfs - FALL_DB_PER_S * max(0.0, now - self._updated)
        self._dbfs = max(fallen, level_dbfs(samples))
        self._updated = now

    @property
    def level(self) -> float:
        """Return the level from 0, FLOOR_DBFS or less, to 1, full scale."""
        return 1 - self._dbfs / FLOOR_DBFS


def level_dbfs(samples: Samples, /) -> float:
    """Return the root mean square of (n,) int16 in decibels below that of a full square wave, at least FLOOR_DBFS."""
    if not len(samples):
        return FLOOR_DBFS
    mean_square = float(np.mean(np.square(samples.astype(np.float64) / _FULL_SCALE)))
    return max(FLOOR_DBFS, 10 * math.log10(max(mean_square, 1e-12)))
