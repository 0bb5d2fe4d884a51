"""Find by how much an echo that was learned has jumped: a device lost sound, or its latency changed.

The room is still the same, so the response that the filter has learned fits again, only later or earlier. What it makes
of what was played is correlated with what was recorded, both whitened by the recording's smoothed spectrum. 60 ms tell
the right shift from chance, also while somebody speaks here, where the delay finder needs a second.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from conf.audio.samples import SAMPLE_RATE

REACH = round(0.15 * SAMPLE_RATE)  # samples that an echo may have jumped, to each side

_MIN_HZ = 300.0
_SMOOTHED_HZ = 75.0  # to each side, of the recording's power
_MIN_POWER = 1e-3  # of the loudest frequency
# Of the peak over the root mean square of all shifts. Right ones reach 12 with a near voice 6 dB louder than the echo,
# 17 without; the highest wrong ones of double talk reach 9.
_MIN_HEIGHT = 11.0
_MIN_CORRELATION = 0.35  # of whitened sounds at the peak


class Shift(NamedTuple):
    """How an echo differs from what was learned. samples : by which it is later; gain : by which it is louder"""

    samples: float
    gain: float


def find_shift(
    recorded: NDArray[np.float32], played: NDArray[np.float32], response: NDArray[np.float32], /
) -> Shift | None:
    """Return how the echo differs from what the response says, or None if that is not certain.

    recorded : (n,) of the microphone
    played : (len(response) + REACH + n + REACH,) of the loudspeaker; without a shift, the echo of
        played[len(response) + REACH :][:n] is in recorded
    response : learned by the filter
    """
    size, first = len(played), len(response)
    estimate = np.fft.rfft(played) * np.fft.rfft(response, size)
    spectrum = np.fft.rfft(recorded, size)
    power = np.abs(spectrum) ** 2
    hertz = SAMPLE_RATE / size
    smoothed = _smooth(power, round(_SMOOTHED_HZ / hertz))
    weights = 1 / (smoothed + _MIN_POWER * smoothed.max() + 1e-12)
    weights[: round(_MIN_HZ / hertz)] = 0
    products = np.fft.irfft(estimate * spectrum.conj() * weights, size)[first : first + 2 * REACH + 1]
    energies = np.cumsum(np.fft.irfft(estimate * np.sqrt(weights), size) ** 2)[first - 1 :]
    energies = energies[len(recorded) :][: 2 * REACH + 1] - energies[: 2 * REACH + 1]
    recorded_energy = 2 / size * (power * weights).sum()
    correlation = products / np.sqrt(np.maximum(energies, 0) * recorded_energy + 1e-12)
    peak = int(np.argmax(correlation))
    is_certain = correlation[peak] > max(_MIN_CORRELATION, _MIN_HEIGHT * np.sqrt(np.mean(correlation**2)))
    if not is_certain or not 0 < peak < 2 * REACH:
        return None
    return Shift(REACH - peak - _vertex(*correlation[peak - 1 : peak + 2]), float(products[peak] / energies[peak]))


def _smooth(values: NDArray[np.float64], reach: int) -> NDArray[np.float64]:
    """Return the mean of each value and its neighbours to both sides; 0 beyond the ends."""
    sums = np.cumsum(np.concatenate([np.zeros(reach + 1), values, np.zeros(reach)]))
    return np.asarray((sums[2 * reach + 1 :] - sums[: len(values)]) / (2 * reach + 1))


def _vertex(before: float, at: float, after: float) -> float:
    """Return where the parabola through three values at -1, 0 and 1 is highest."""
    return float((before - after) / (2 * (before - 2 * at + after)))
