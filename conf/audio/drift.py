"""Keep captured sound on the program's clock: sound cards run fast or slow by up to some 100 parts per million.

A block's time of arrival is late by an unknown, changing amount, never early. The least lateness of some seconds is
therefore compared with the time that the count of samples says, and the sound is resampled by a fraction of a per mille
so that the two meet within seconds. No clock changes the least lateness by a millisecond from one moment to the next:
such a step is a loudspeaker that got nothing to play for so long, or a sound server that hands on sound sooner or later
than before. The first leaves a gap. The second says nothing of the samples' rate and is left out of account: an echo's
delay would change by 1 ms a second if the sound were resampled until it is made good, which no filter follows.
"""

from collections import deque

import numpy as np
from numpy.typing import NDArray

from conf.audio.samples import SAMPLE_RATE, AudioBlock, Samples, to_int16

_WINDOW_S = 2.0  # over which the least lateness counts
_CORRECTION_S = 8.0  # time constant of the correction: a card off by 300 ppm stays within 2.4 ms plus the window's 0.6
_MAX_RATE = 1e-3  # relative change of rate, inaudible (1.7 cents)
_MAX_IGNORED_S = 0.03  # by more than this time stamps must not be late, as lips and voice would part
_STARTING_S = 1.0  # for which every step is made good: the first blocks come late, and nobody has learned a delay
DROPOUT_S = 0.05  # a step of a microphone's lateness by more than this is a dropout
# A loudspeaker takes nothing while it is not asked to: if it takes sound later than before, it was silent meanwhile.
PLAYED_DROPOUT_S = 0.0
_STEP_S = 0.0008  # a larger change is a step: more than 300 ppm in the window
_STEP_AFTER_S = 0.2  # a step upwards lasts; a single late block is none
# A step upwards counts once chance makes all blocks so late with a probability of exp(-14): lateness is about
# exponential, and n blocks are all later than the least by t with probability exp(-n t / mean).
_STEP_CERTAINTY = 14.0
_HALF = 8  # zero crossings of the interpolating sinc to each side
_PHASES = 64


class ClockAligner:
    """The samples of one device on the clock of their time stamps."""

    def __init__(self, *, dropout_s: float = DROPOUT_S) -> None:
        """dropout_s : a step upwards by more than this leaves a gap"""
        self._dropout_s = dropout_s
        self._resampler = _FractionalResampler()
        # Time stamp; time stamp minus duration of all before it, less the steps that are left out of account.
        self._offsets: deque[tuple[float, float]] = deque()
        self._offset: float | None = None  # the one in force
        self._started = 0.0  # time stamp of the first block
        self._ignored_s = 0.0  # sum of the steps left out of account
        self._gap = (-np.inf, 0.0)  # time stamp and duration of the last one
        self._late: list[tuple[float, float]] = []  # the newest of the offsets, all late
        self._received_s = 0.0  # duration of all input
        self._surplus = 0  # input samples still to be left out

    def align(self, block: AudioBlock, /) -> AudioBlock:
        """Return a block's samples at SAMPLE_RATE of the clock.

        block.timestamp : when its first sample was captured, s, late by a changing amount
        The next block's time stamp is this one's end, but after a dropout, which leaves a gap.
        """
        if self._offset is None:
            self._offset, self._started = block.timestamp - self._received_s, block.timestamp
        self._follow_steps(block.timestamp)
        error = self._error
        timestamp = self._offset + self._received_s - self._resampler.delay_s
        self._received_s += len(block.samples) / SAMPLE_RATE
        samples = self._resampler.process(self._without_surplus(block.samples), self._step(error))
        self._offset += (len(samples) - len(block.samples)) / SAMPLE_RATE
        return AudioBlock(timestamp, samples)

    def _follow_steps(self, timestamp: float) -> None:
        """Add the offset of a block; tell a step of the lateness from drift."""
        assert self._offset is not None
        offset = timestamp - self._received_s - self._ignored_s
        least = min((offset for _, offset in self._offsets), default=self._offset)
        self._offsets.append((timestamp, offset))
        while self._offsets[0][0] < timestamp - _WINDOW_S:
            self._offsets.popleft()
        if offset > least + _STEP_S:
            self._late.append((timestamp, offset))
            self._step_up(least)
            return
        self._late = []
        if offset < least - _STEP_S:
            self._step_down(offset - least, timestamp)

    def _step_up(self, least: float) -> None:
        """Follow a step upwards once it is certain."""
        assert self._offset is not None
        step = min(offset for _, offset in self._late) - least
        before = [offset for _, offset in self._offsets][: -len(self._late)]
        mean = sum(before) / len(before) - least if before else 0.0
        if self._late[-1][0] - self._late[0][0] < _STEP_AFTER_S or step * len(self._late) < _STEP_CERTAINTY * mean:
            return
        if step > self._dropout_s or self._ignored_s + step > DROPOUT_S:
            self._offset += step
            self._gap = (self._late[-1][0], step)
            self._offsets = deque(self._late)
        else:
            self._ignored_s += step
            self._offsets = deque((at, offset - step) for at, offset in self._late)
        self._late = []

    def _step_down(self, step: float, timestamp: float) -> None:
        """Leave a step downwards out of account, or samples: at the start, and if the last gap was none."""
        gap_at, gap_s = self._gap
        is_start = timestamp < self._started + _STARTING_S
        was_no_gap = timestamp < gap_at + _WINDOW_S and -step < gap_s + _STEP_S
        if is_start or was_no_gap or self._ignored_s + step < -_MAX_IGNORED_S:
            self._surplus = round(-self._error * SAMPLE_RATE)
        else:
            self._ignored_s += step
            self._offsets[-1] = (timestamp, self._offsets[-1][1] - step)

    @property
    def _error(self) -> float:
        """Return how much later than the offset in force the least late block is, s."""
        assert self._offset is not None
        return min(offset for _, offset in self._offsets) - self._offset

    def _step(self, error: float) -> float:
        """Return the input samples for each output sample that remove an error."""
        if self._surplus:
            return 1.0
        return 1 - float(np.clip(error / _CORRECTION_S, -_MAX_RATE, _MAX_RATE))

    def _without_surplus(self, samples: Samples) -> Samples:
        kept = samples[self._surplus :]
        self._surplus -= len(samples) - len(kept)
        return kept


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
