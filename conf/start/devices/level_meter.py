"""The level of a sound as a meter shows it."""

from conf.audio.samples import Samples, level_dbfs

FLOOR_DBFS = -60.0  # of a meter that shows nothing; quiet rooms are below
FALL_DB_PER_S = 24.0  # IEC 60268-10 type I: 20 dB in 1.7 s is slow for speech; twice as fast


class LevelMeter:
    """Rises at once, falls slowly."""

    def __init__(self) -> None:
        self._dbfs = FLOOR_DBFS
        self._updated = 0.0

    def update(self, samples: Samples, now: float, /) -> None:
        """Use the newest samples, which may be none. now : s"""
        fallen = self._dbfs - FALL_DB_PER_S * max(0.0, now - self._updated)
        self._dbfs = max(fallen, level_dbfs(samples), FLOOR_DBFS)
        self._updated = now

    @property
    def level(self) -> float:
        """Return the level from 0, FLOOR_DBFS or less, to 1, full scale."""
        return 1 - self._dbfs / FLOOR_DBFS
