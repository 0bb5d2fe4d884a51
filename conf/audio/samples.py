"""The one format of sound inside the program: 16 kHz, mono, int16, in blocks that know when they were captured."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

SAMPLE_RATE = 16000  # samples a second
FULL_SCALE = 32768.0
SILENCE_DBFS = -96.0  # below half a step of 16 bits

Samples = NDArray[np.int16]


@dataclass(frozen=True)
class AudioBlock:
    """Consecutive samples.

    timestamp : time of the first sample, s, on the clock of whoever made the block
    samples : (n,) int16, mono, SAMPLE_RATE
    """

    timestamp: float
    samples: Samples

    @property
    def end(self) -> float:
        """Return the time of the sample that would follow, s."""
        return self.timestamp + len(self.samples) / SAMPLE_RATE


def to_int16(values: NDArray[np.float64], /) -> Samples:
    """Return float samples in int16 units as int16, rounded and clipped."""
    return np.minimum(np.maximum(np.rint(values), -32768), 32767).astype(np.int16)


def level_dbfs(samples: Samples, /) -> float:
    """Return the root mean square of samples in dB below full scale, SILENCE_DBFS at least and for no samples."""
    if not len(samples):
        return SILENCE_DBFS
    values = samples.astype(np.float64)
    return power_dbfs(float(values @ values) / len(values) / FULL_SCALE**2)


def power_dbfs(power: float, /) -> float:
    """Return a mean square, that of full scale being 1, in dB below full scale, SILENCE_DBFS at least."""
    return max(SILENCE_DBFS, 10 * math.log10(max(power, 1e-12)))


def amplitude(dbfs: float, /) -> float:
    """Return the root mean square, in int16 units, of a level in dBFS; 0 at SILENCE_DBFS and below."""
    return FULL_SCALE * 10.0 ** (dbfs / 20) if dbfs > SILENCE_DBFS else 0.0
