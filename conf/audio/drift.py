"""Keep captured sound on the program's clock: sound cards run fast or slow by up to some 100 parts per million.

A block's time of arrival is late by an unknown, changing amount, never early. The least lateness of some seconds is
therefore compared with the time that the count of samples says, and the sound is resampled by a fraction of a per mille
so that the two meet within seconds. A lasting difference beyond a few hundredths is a dropout of the device. Where a
gap does no harm, a smaller one is a dropout too: no clock is so wrong, and resampling would take long.
"""

from collections import deque

import numpy as np
from numpy.typing import NDArray

from conf.audio.samples import SAMPLE_RATE, AudioBlock, Samples, to_int16

_WINDOW_S = 3.0  # over which the least lateness counts
_CORRECTION_S = 8.0  # time constant of the correction: a card off by 300 ppm stays within 2.4 ms plus the window's 0.9
_MAX_RATE = 1e-3  # relative change of rate, inaudible (1.7 cents)
_EARLY_S = 0.01  # blocks cannot be early: by more than this the first blocks came late, and samples are left out
DROPOUT_S = 0.05  # a lasting difference beyond this is a dropout
# The same of what a loudspeaker plays: a buffer that ran empty for 10 ms would be an echo whose delay changes by 1 ms a
# second for as many seconds, which no filter follows.
PLAYED_DROPOUT_S = 0.006
_DROPOUT_AFTER_S = 1.0
_HALF = 8  # zero crossings of the interpolating sinc to each side
_PHASES = 64


class ClockAligner:
    """The samples of one device on the clock of their time stamps."""

    def __init__(self, *, dropout_s: float = DROPOUT_S) -> None:
        """dropout_s : a lasting difference beyond this leaves a gap"""
        self._dropout_s = dropout_s
        self._resampler = _FractionalResampler()
        self._offsets: deque[tuple[float, float]] = deque()  # time stamp, time stamp minus duration of all before it
        self._offset: float | None = None  # the one in force
        self._received_s = 0.0  # duration of all input
        self._surplus = 0  # input samples still to be left out

    def align(self, block: AudioBlock, /) -> AudioBlock:
        """Return a block's samples at SAMPLE_RATE of the clock.

        block.timestamp : when its first sample was captured, s, late by a changing amount
        The next block's time stamp is this one's end, but after a dropout, which leaves a gap.
        """
        offset = block.timestamp - self._received_s
        self._offsets.append((block.timestamp, offset))
        self._forget_before(block.timestamp - _WINDOW_S)
        if self._offset is None:
            self._offset = offset
        error = self._error(block.timestamp - _DROPOUT_AFTER_S)
        if error > self._dropout_s and self._offsets[0][0] < block.timestamp - _DROPOUT_AFTER_S:
            self._forget_before(block.timestamp - _DROPOUT_AFTER_S)
            self._offset += error
        error = self._error()
        if error < -_EARLY_S and not self._surplus:
            self._surplus = round(-error * SAMPLE_RATE)
        timestamp = self._offset + self._received_s - self._resampler.delay_s
        self._received_s += len(block.samples) / SAMPLE_RATE
        samples = self._resampler.process(self._without_surplus(block.samples), self._step(error))
        self._offset += (len(samples) - len(block.samples)) / SAMPLE_RATE
        return AudioBlock(timestamp, samples)

    def _error(self, since: float = -np.inf) -> float:
        """Return how much later than the offset in force the least late block since a time was, s."""
        assert self._offset is not None
        return min(offset for at, offset in self._offsets if at >= since) - self._offset

    def _step(self, error: float) -> float:
        """Return the input samples for each output sample that remove an error."""
        if self._surplus:
            return 1.0
        return 1 - float(np.clip(error / _CORRECTION_S, -_MAX_RATE, _MAX_RATE))

    def _without_surplus(self, samples: Samples) -> Samples:
        kept = samples[self._surplus :]
        self._surplus -= len(samples) - len(kept)
        return kept

    def _forget_before(self, time: float) -> None:
        while self._offsets[0][0] < time:
            self._offsets.popleft()


class _FractionalResampler:
    """Resampling by a ratio near 1 that may change with each block: a windowed sinc, interpolated between phases."""

    delay_s = _HALF / SAMPLE_RATE

    def __init__(self) -> None:
        offsets = np.arange(2 * _HALF) - _HALF + 1 - np.arange(_PHASES + 1)[:, None] / _PHASES
        window = 0.5 + 0.5 * np.cos(np.pi * np.clip(offsets / _HALF, -1, 1))
        filters = np.sinc(offsets) * window
        self._filters = filters / filters.sum(axis=1, keepdims=True)
        self._tail = np.zeros(2 * _HALF - 1)
        self._position = 0.0

    def process(self, samples: Samples, step: float) -> Samples:
        """Return samples at positions that advance by step input samples each."""
        values = np.concatenate([self._tail, samples.astype(np.float64)])
        count = max(0, int(np.ceil((len(samples) - self._position) / step)))
        positions = self._position + step * np.arange(count)
        self._position += step * count - len(samples)
        self._tail = values[len(values) - 2 * _HALF + 1 :]
        if not count:
            return np.zeros(0, np.int16)
        whole = np.minimum(positions.astype(np.int64), len(samples) - 1)
        phases = (positions - whole) * _PHASES
        rows = np.minimum(phases.astype(np.int64), _PHASES - 1)
        weights = self._interpolate(rows, phases - rows)
        windows = np.lib.stride_tricks.sliding_window_view(values, 2 * _HALF)[whole]
        return to_int16(np.einsum("nt,nt->n", windows, weights))

    def _interpolate(self, rows: NDArray[np.int64], fractions: NDArray[np.floating]) -> NDArray[np.float64]:
        below, above = self._filters[rows], self._filters[rows + 1]
        return np.asarray(below + fractions[:, None] * (above - below))
