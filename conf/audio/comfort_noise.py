"""Fill a talker's pauses with noise of the level of the background, so that silence does not sound like a broken line.

Source: RFC 3389 for the idea; the spectrum here is fixed, falling from 600 Hz on as in most rooms.
"""

import numpy as np

from conf.audio.samples import SAMPLE_RATE, Samples, amplitude, to_int16

_CORNER_HZ = 600.0
_TAPS = 64
_GLIDE_S = 0.02  # the level reaches another within about twice this


class ComfortNoise:
    """One talker's noise. Blocks follow each other without seams."""

    def __init__(self, rng: np.random.Generator) -> None:
        decay = np.exp(-2 * np.pi * _CORNER_HZ / SAMPLE_RATE * np.arange(_TAPS))
        self._filter = decay / np.sqrt(decay @ decay)  # unit power
        self._rng = rng
        self._tail = rng.standard_normal(_TAPS - 1)
        self._gain = 0.0

    def generate(self, count: int, level_dbfs: float) -> Samples:
        """Return count samples whose level glides to level_dbfs; SILENCE_DBFS turns the noise off."""
        target = amplitude(level_dbfs)
        white = np.concatenate([self._tail, self._rng.standard_normal(count)])
        self._tail = white[count:]
        if not count or (target == 0 and self._gain < 0.1):
            self._gain = 0.0 if count else self._gain
            return np.zeros(count, np.int16)
        decay = np.exp(-np.arange(1, count + 1) / (_GLIDE_S * SAMPLE_RATE))
        gains = target + (self._gain - target) * decay
        self._gain = float(gains[-1])
        return to_int16(gains * np.convolve(white, self._filter, mode="valid"))
