"""Change the sample rate of a stream by a ratio of small integers.

Method: polyphase windowed-sinc filter (Crochiere, Rabiner 1983). Output sample k is the input at time k M / L, where
L / M is the ratio in lowest terms; each of the L phases of the fraction has a filter of its own.
"""

from math import gcd

import numpy as np
from numpy.typing import NDArray

from conf.audio.samples import Samples, to_int16

_HALF_WIDTH = 16  # zero crossings of the sinc on each side, at the lower of both rates
_KAISER_BETA = 8.0  # stop band at -80 dB
_CUTOFF = 0.92  # of the lower Nyquist frequency; the transition band ends there


class Resampler:
    """A stream's change of rate. Blocks may have any length; their borders leave no trace.

    delay_s : by how much the output lags behind the input, s
    """

    def __init__(self, source_rate: int, target_rate: int) -> None:
        """Design the filter. Rates in samples a second; 44100 to 16000 needs a filter of 160 phases, which works."""
        if source_rate < 1 or target_rate < 1:
            raise ValueError("source_rate and target_rate must be positive")
        divisor = gcd(source_rate, target_rate)
        self._up, self._down = target_rate // divisor, source_rate // divisor
        lower = min(1.0, self._up / self._down)  # the lower rate, in input rates
        half = int(np.ceil(_HALF_WIDTH / lower))  # in input samples
        self._taps = 2 * half
        self._filters = _design(self._up, half, _CUTOFF * lower)
        self.delay_s = half / source_rate
        self._tail = np.zeros(self._taps - 1)
        self._windows = np.zeros((0, self._taps), np.intp)  # numbers of the values that make each new sample
        self._position = 0  # of the next output sample from the first new input sample, in 1/up input samples

    def process(self, samples: Samples, /) -> Samples:
        """Return the samples at the target rate that this block completes: n L / M of them, give or take one."""
        if not len(samples):
            return samples
        values = np.concatenate([self._tail, samples.astype(np.float64)])
        end = len(samples) * self._up
        positions = np.arange(self._position, end, self._down)
        self._position += len(positions) * self._down - end
        self._tail = values[len(values) - self._taps + 1 :]
        if self._down == 1:  # each phase of each window: one product
            if len(self._windows) < len(samples):
                self._windows = np.arange(len(samples))[:, None] + np.arange(self._taps)
            return to_int16((values[self._windows[: len(samples)]] @ self._filters.T).ravel())
        starts, phases = positions // self._up, positions % self._up
        windows = np.lib.stride_tricks.sliding_window_view(values, self._taps)[starts]
        if self._up == 1:
            return to_int16(windows @ self._filters[0])
        return to_int16(np.einsum("nt,nt->n", windows, self._filters[phases]))


def _design(phases: int, half: int, cutoff: float) -> NDArray[np.float64]:
    """Return (phases, 2 half) filters, each of gain 1 at 0 Hz. cutoff : of the input's Nyquist frequency."""
    offsets = np.arange(2 * half) - half + 1 - np.arange(phases)[:, None] / phases
    window = np.i0(_KAISER_BETA * np.sqrt(np.maximum(0.0, 1 - (offsets / half) ** 2))) / np.i0(_KAISER_BETA)
    filters = cutoff * np.sinc(cutoff * offsets) * window
    return np.asarray(filters / filters.sum(axis=1, keepdims=True))
