"""Find by how much the echo of a loudspeaker is later than what it played.

Method: generalised cross-correlation with phase transform (Knapp, Carter 1976) of what was played and what the
microphone recorded. The whitened cross-spectra of several windows are averaged, so that the echo's peak grows over the
noise that near voices leave. The peak counts if it is higher than chance would have it among all lags.
"""

import numpy as np
from numpy.typing import NDArray

from conf.audio.echo_filter import rfft
from conf.audio.samples import SAMPLE_RATE


def tapered_cosine(size: int, tapered: float, /) -> NDArray[np.float32]:
    """Return a window (size,) whose edges, together that fraction of it, rise and fall as half a cosine.

    Source: Harris, "On the Use of Windows for Harmonic Analysis", 1978 (Tukey window). scipy.signal has it, but takes
    half a second to import.
    """
    edge = tapered * (size - 1) / 2
    from_edge = np.minimum(np.arange(size), np.arange(size)[::-1])
    return np.asarray((1 - np.cos(np.pi * np.minimum(1, from_edge / edge))) / 2, np.float32)


MAX_DELAY_S = 0.5  # Bluetooth loudspeakers need 0.2 to 0.3 s

_STEP = SAMPLE_RATE // 4  # samples from window to window
_SEARCH_STEP = SAMPLE_RATE // 8  # while the delay is not known
_NEAR = SAMPLE_RATE // 2  # samples of a window of the microphone
_MAX_LAG = round(MAX_DELAY_S * SAMPLE_RATE)
_FAR = _NEAR + _MAX_LAG  # samples of a window of the loudspeaker: the microphone's and what was played before
_SIZE = _FAR  # of the transforms: 16000 has no prime factors but 2 and 5, so they are fast
_BAND_HZ = (200.0, 4000.0)  # where speech is above the noise
_MEMORY = 0.75  # of the average, from window to window
_MIN_NEAR_POWER = 1e-6  # -60 dBFS: quieter windows have nothing to find
_MIN_FAR_POWER = 1e-4  # -40 dBFS: below speech, hum is at both ends and of one frequency
_HIGH = 11.0  # height of a peak over the root mean square of all lags; two voices without an echo reach 10
_SAME = round(0.002 * SAMPLE_RATE)  # samples; peaks closer than this are one path
_REPEATS = 3  # windows that must agree before the delay changes
# Edges of both windows would match each other at no delay.
_NEAR_TAPER = tapered_cosine(_NEAR, 0.5)
_FAR_TAPER = tapered_cosine(_FAR, 0.25)


class DelayFinder:
    """The delay between one loudspeaker and one microphone.

    delay : samples from played to recorded, None while no echo was found; it follows drifting clocks
    confidence : height of the newest peak over the root mean square of all lags; 0 before there was one
    """

    def __init__(self) -> None:
        self.delay: int | None = None
        self.confidence = 0.0
        self._near = np.zeros(_NEAR, np.float32)
        self._far = np.zeros(_FAR, np.float32)
        self._fresh = 0  # samples since the last window
        self._average = np.zeros(_SIZE // 2 + 1, np.complex64)
        hertz = np.fft.rfftfreq(_SIZE, 1 / SAMPLE_RATE)
        self._band = (hertz >= _BAND_HZ[0]) & (hertz <= _BAND_HZ[1])
        self._candidate, self._agreed = 0, 0
        self._is_searching = True

    def update(self, recorded: NDArray[np.float32], played: NDArray[np.float32], /) -> bool:
        """Add sound of the same time, (n,) each, full scale 1; return whether the delay changed.

        Windows in which the loudspeaker or the microphone is silent change nothing.
        """
        self._near = _append(self._near, recorded)
        self._far = _append(self._far, played)
        self._fresh += len(recorded)
        if self._fresh < (_SEARCH_STEP if self._is_searching else _STEP):
            return False
        self._fresh = 0
        if _power(self._near) < _MIN_NEAR_POWER or _power(self._far) < _MIN_FAR_POWER:
            return False
        return self._judge(*self._find_peak())

    def restart(self, delay: int | None, /) -> None:
        """Forget what was heard. delay : samples, the one in force until another is found"""
        self.delay = delay
        self._near[:] = self._far[:] = 0
        self._average[:] = 0
        self._agreed = 0
        self._is_searching = True

    def _find_peak(self) -> tuple[int, float]:
        """Return lag and height of the highest peak of the averaged correlation."""
        cross = rfft(self._near * _NEAR_TAPER, _SIZE) * rfft(self._far * _FAR_TAPER, _SIZE).conj()
        magnitude = np.abs(cross)
        cross[~self._band] = 0
        cross /= magnitude + np.float32(1e-6) * magnitude.max() + np.float32(1e-9)
        self._average = np.float32(_MEMORY) * self._average + cross
        # The microphone's window begins _MAX_LAG samples after the loudspeaker's: at no delay the lag is -_MAX_LAG.
        correlation = np.abs(np.roll(np.fft.irfft(self._average, _SIZE), _MAX_LAG)[: _MAX_LAG + 1])
        lag = int(np.argmax(correlation))
        return lag, float(correlation[lag] / np.sqrt(np.mean(correlation**2) + 1e-30))

    def _judge(self, lag: int, height: float) -> bool:
        """Return whether a peak is a new delay."""
        self.confidence = height
        if height < _HIGH:
            self._agreed = 0
            return False
        self._agreed = self._agreed + 1 if abs(lag - self._candidate) <= _SAME else 1
        self._candidate = lag
        if self._agreed >= _REPEATS:
            self._is_searching = False
        has_changed = self.delay is None or abs(lag - self.delay) > _SAME
        if not has_changed or self._agreed >= _REPEATS:
            self.delay = lag
        return has_changed and self._agreed >= _REPEATS


def _append(window: NDArray[np.float32], samples: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return the newest samples, as many as the window has."""
    return np.concatenate([window, samples])[-len(window) :]


def _power(samples: NDArray[np.float32]) -> float:
    return float(np.square(samples).mean())
