"""Learn the path from loudspeaker to microphone and subtract the echo: the linear half of echo cancellation.

Method: Kalman filter in the frequency domain with partitions (Enzner, Vary 2006; Kuech, Mabande, Enzner 2014), overlap
save, constrained. Each weight has a variance: its step is large while little is known and small while somebody
speaks into the microphone, so that no detector of double talk is needed.
"""

import numpy as np
from numpy.typing import NDArray

from conf.audio.samples import SAMPLE_RATE

BLOCK = SAMPLE_RATE // 50  # samples: 20 ms, half the processor time that 10 ms cost
PARTITIONS = 12  # blocks that the response of the room may last: 0.24 s
BINS = BLOCK + 1

_TRANSITION = np.float32(0.9995**2)  # of a weight's power from block to block: the room changes within some 10 s
_DECAY_S = 0.5  # in which the room's response, and so the first variance, decays by 60 dB
_NEAR_MEMORY = np.float32(0.6)  # of the power of what is no echo, from block to block: 40 ms
_MIN_POWER = np.float32(1e-4)  # of a bin, full scale 1: what is no echo is never quieter than -65 dBFS
# How much of what theory says a block reduces the variance. Theory takes blocks for independent; those of a vowel are
# not, and the variance fell too early (3 to 5 s after the start the echo was 7 dB louder).
_TRUST = np.float32(0.35)
# The estimated echo is regressed on what was recorded, each frequency weighted by the inverse of its power. The slope
# is 1 if the filter fits, whatever is said here, and near 0 if the echo has jumped.
_FIT_MEMORY = 0.5  # from block to block: a jump shows after 40 to 60 ms
_FIT_BINS = slice(13, None)  # from 300 Hz
_FIT_SMOOTHING = np.full(9, 1 / 9, np.float32)  # of the power, over bins
_FIT_MIN_POWER = np.float32(1e-3)  # of a bin: quieter frequencies have little weight
_FIT_MIN_WEIGHT = 40.0  # of the estimated echo, from which the slope tells something
_GOOD_SLOPE, _LOST_SLOPE = 0.7, 0.5
_PAD = np.zeros(BLOCK, np.float32)


class EchoFilter:
    """The response of one room, in partitions of BLOCK samples.

    residual_power : (BINS,) float32, expected power of the echo that is left in the newest block's spectrum
    """

    def __init__(self) -> None:
        self._spectra = np.zeros((PARTITIONS, BINS), np.complex64)  # of what was played, newest first
        self.reset()

    def reset(self, power_ratio: float = 0.2, /) -> None:
        """Forget the room. power_ratio : of the echo to what was played, roughly"""
        self._weights = np.zeros((PARTITIONS, BINS), np.complex64)
        self._near_power = np.full(BINS, 1e-4, np.float32)
        self.residual_power = np.zeros(BINS, np.float32)
        decay = 10 ** (-6 * np.arange(PARTITIONS) * BLOCK / (SAMPLE_RATE * _DECAY_S))
        prior = (power_ratio / decay.sum() * decay).astype(np.float32)
        self._variance = np.repeat(prior[:, None], BINS, axis=1)
        self._product = self._weight = 0.0  # of echo and recording, of the echo: their ratio is the slope

    @property
    def is_fitting(self) -> bool:
        """Return whether the newest blocks have the echo that was estimated."""
        return self._weight > _FIT_MIN_WEIGHT and self._product >= _GOOD_SLOPE * self._weight

    @property
    def is_doubtful(self) -> bool:
        """Return whether the newest blocks may have another echo: nothing is learned from them."""
        return self._weight > _FIT_MIN_WEIGHT and self._product < _GOOD_SLOPE * self._weight

    @property
    def is_lost(self) -> bool:
        """Return whether they most likely have: as much as was estimated is expected to be left."""
        return self._weight > _FIT_MIN_WEIGHT and self._product < _LOST_SLOPE * self._weight

    @property
    def response(self) -> NDArray[np.float32]:
        """Return the learned response, (PARTITIONS * BLOCK,)."""
        return np.fft.irfft(self._weights)[:, :BLOCK].ravel().astype(np.float32, copy=False)

    def change_response(self, samples: float, gain: float, /) -> None:
        """Delay what was learned by less than a sample or two, and make it louder; forget how it fitted."""
        response = self.response
        factor = gain * np.exp(-2j * np.pi * np.fft.rfftfreq(len(response)) * samples)
        changed = np.fft.irfft(np.fft.rfft(response) * factor).reshape(PARTITIONS, BLOCK)
        self._weights = rfft(changed, 2 * BLOCK)
        self._product = self._weight = 0.0

    def set_history(self, played: NDArray[np.float32], /) -> None:
        """Set what was played before the next block, ((PARTITIONS + 1) * BLOCK,)."""
        blocks = np.lib.stride_tricks.sliding_window_view(played, 2 * BLOCK)[::BLOCK]
        self._spectra = rfft(blocks[::-1])

    def process(self, recorded: NDArray[np.float32], played: NDArray[np.float32], /) -> NDArray[np.float32]:
        """Return the estimated echo in a block.

        recorded : (BLOCK,) of the microphone, full scale 1
        played : (2 * BLOCK,) of the loudspeaker, the block before and this one
        """
        self._spectra[1:] = self._spectra[:-1]
        self._spectra[0] = rfft(played)
        echo = np.fft.irfft(np.einsum("pk,pk->k", self._spectra, self._weights))[BLOCK:].astype(np.float32, copy=False)
        error = rfft(np.concatenate([_PAD, recorded - echo]))
        # Half a spectrum's power is in the half of the samples that counts.
        shares = np.float32(0.5) * self._variance * power(self._spectra)
        self.residual_power = shares.sum(axis=0)
        self._near_power = _NEAR_MEMORY * self._near_power + (1 - _NEAR_MEMORY) * power(error)
        total = self.residual_power + self._near_power + _MIN_POWER
        spectrum = rfft(np.concatenate([_PAD, echo]))
        self._update_fit(spectrum, error)
        if self.is_lost:
            self.residual_power = self.residual_power + power(spectrum)
        if not self.is_doubtful:
            self._adapt(error / total, shares / total)
        return echo

    def _update_fit(self, echo: NDArray[np.complex64], error: NDArray[np.complex64]) -> None:
        echo, error = echo[_FIT_BINS], error[_FIT_BINS]
        echo_power = power(echo)
        weights = 1 / (np.convolve(echo_power + power(error), _FIT_SMOOTHING, "same") + _FIT_MIN_POWER)
        weight = float(weights @ echo_power)
        product = weight + float(weights @ (echo * error.conj()).real)
        self._weight = _FIT_MEMORY * self._weight + weight
        self._product = _FIT_MEMORY * self._product + product

    def _adapt(self, error: NDArray[np.complex64], gains: NDArray[np.float32]) -> None:
        """Move the weights by the error over its power; gains : (PARTITIONS, BINS) share of it that each explains."""
        steps = np.fft.irfft(self._variance * self._spectra.conj() * error)
        steps[:, BLOCK:] = 0  # a partition is BLOCK samples long
        self._weights += rfft(steps)
        self._variance *= _TRANSITION * (1 - _TRUST * gains)
        self._variance += (1 - _TRANSITION) * power(self._weights)


def power(spectrum: NDArray[np.complex64], /) -> NDArray[np.float32]:
    """Return the squared magnitudes."""
    return np.asarray(spectrum.real**2 + spectrum.imag**2)


def rfft(samples: NDArray[np.floating], size: int | None = None, /) -> NDArray[np.complex64]:
    """Return the spectrum of the last axis. NumPy before version 2 computes it in double precision."""
    return np.fft.rfft(samples, size).astype(np.complex64, copy=False)
