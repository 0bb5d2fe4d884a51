"""Attenuate the echo that the linear filter leaves: late reverberation, a distorting loudspeaker, a changing room.

The power of the residual echo is expected from two sides: from the variance of the filter's weights, and from the power
of the estimated echo, prolonged by reverberation, times a leakage that is tracked for each band at its minima (Valin
2007). Each frequency then gets the gain of a Wiener filter whose ratio of near voice to echo is smoothed by decision
(Ephraim, Malah 1984). While somebody speaks here, gains have a higher floor: a little echo is better than a torn voice.
"""

import numpy as np
from numpy.typing import NDArray

from conf.audio.echo_filter import power, rfft
from conf.audio.samples import SAMPLE_RATE

HOP = SAMPLE_RATE // 100  # samples between frames: 10 ms, the delay of the output
BINS = HOP + 1

_WINDOW = np.sqrt(0.5 - 0.5 * np.cos(np.pi * np.arange(2 * HOP) / HOP)).astype(np.float32)
_EDGES = np.array([0, 2, 4, 6, 8, 10, 12, 14, 16, 19, 23, 27, 33, 39, 47, 56, 67, 79, 95, 113, 135])  # bins of 50 Hz
_WIDTHS = np.diff(np.append(_EDGES, BINS))
_OVERESTIMATE, _NEAR_OVERESTIMATE = 12.0, 4.0  # of the residual echo: its power fluctuates, leakage comes from minima
_REVERBERATION = np.float32(10 ** (-6 * 0.01 / 0.6))  # decay of the echo's power in a frame: by 60 dB in 0.6 s
_DOWN, _UP = 0.15, 1.007  # of the leakage, in a frame: towards lower values, and 3 dB a second upwards
_SMOOTHING = np.float32(0.9)  # of the ratio of near voice to echo
_FLOOR, _NEAR_FLOOR = 0.03, 0.25  # lowest gain, while nobody speaks here and while somebody does
_NEAR_RATIO = 8.0  # power over that of the expected echo, from which somebody speaks here
_NEAR_DECAY = 0.8  # in a frame
_SPEECH = slice(6, 100)  # bins: 300 to 5000 Hz
_MIN_POWER = np.float32(1e-9)


class EchoSuppressor:
    """The gains of one stream. The output is HOP samples later than the input."""

    def __init__(self) -> None:
        self._error = np.zeros(HOP, np.float32)  # the hop before
        self._echo = np.zeros(HOP, np.float32)
        self._overlap = np.zeros(HOP, np.float32)
        self.reset()

    def reset(self) -> None:
        """Forget how well the filter does."""
        self._leakage = np.ones(len(_EDGES))
        self._echo_power = np.zeros(BINS, np.float32)
        self._near_power = np.zeros(BINS, np.float32)
        self._near = 0.0  # 1 while somebody speaks here

    def process(
        self, error: NDArray[np.float32], echo: NDArray[np.float32], residual_power: NDArray[np.float32], /
    ) -> NDArray[np.float32]:
        """Return the (HOP,) samples before these, with the echo attenuated.

        error : (HOP,) microphone less echo; echo : (HOP,) the estimated echo; full scale 1
        residual_power : (BINS,) of the echo in the error as the linear filter expects it, of a spectrum of HOP samples
        """
        spectrum = rfft(np.concatenate([self._error, error]) * _WINDOW)
        echo_spectrum = rfft(np.concatenate([self._echo, echo]) * _WINDOW)
        self._error, self._echo = error, echo
        gains = self._gains(power(spectrum), power(echo_spectrum), residual_power)
        frame = np.fft.irfft(spectrum * gains).astype(np.float32, copy=False) * _WINDOW
        output = self._overlap + frame[:HOP]
        self._overlap = frame[HOP:]
        return output

    def bypass(self, samples: NDArray[np.float32], /) -> NDArray[np.float32]:
        """Return the (HOP,) samples before these: there is no echo."""
        output = self._overlap + self._error * _WINDOW[:HOP] ** 2
        self._error, self._echo = samples, np.zeros(HOP, np.float32)
        self._overlap = samples * _WINDOW[HOP:] ** 2
        return output

    def _gains(
        self, total: NDArray[np.float32], echo: NDArray[np.float32], residual_power: NDArray[np.float32]
    ) -> NDArray[np.float32]:
        """Return the gain of each bin. total : power of the error; echo : power of the estimated echo"""
        self._echo_power = np.maximum(echo, _REVERBERATION * self._echo_power + (1 - _REVERBERATION) * echo)
        leakage = np.repeat(self._track_leakage(total), _WIDTHS).astype(np.float32)
        residual = leakage * self._echo_power + residual_power + _MIN_POWER
        is_near = total[_SPEECH].sum() > _NEAR_RATIO * residual[_SPEECH].sum()
        self._near = 1.0 if is_near else _NEAR_DECAY * self._near
        residual *= np.float32(_OVERESTIMATE + (_NEAR_OVERESTIMATE - _OVERESTIMATE) * self._near)
        ratio = _SMOOTHING * self._near_power / residual + (1 - _SMOOTHING) * np.maximum(total / residual - 1, 0)
        gains: NDArray[np.float32] = np.maximum(
            ratio / (1 + ratio), np.float32(_FLOOR + (_NEAR_FLOOR - _FLOOR) * self._near)
        )
        self._near_power = gains * gains * total
        return gains

    def _track_leakage(self, total: NDArray[np.float32]) -> NDArray[np.float64]:
        """Return the power of the error over that of the echo in each band, at its minima, 1 at most."""
        echo = _band_means(self._echo_power)
        ratio = _band_means(total) / (echo + 1e-9)
        rising = np.minimum(self._leakage * _UP, 1.0)
        tracked = np.where(ratio < self._leakage, self._leakage + _DOWN * (ratio - self._leakage), rising)
        self._leakage = np.where(echo > 1e-6, tracked, self._leakage)
        return self._leakage


def _band_means(values: NDArray[np.float32]) -> NDArray[np.float64]:
    return np.asarray(np.add.reduceat(values, _EDGES) / _WIDTHS)
