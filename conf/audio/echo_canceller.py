"""Remove from the microphone's sound what the loudspeaker plays: find the delay, learn the room, attenuate the rest.

What was played is kept in a row, with the time of its start. Until an echo is found, with headphones always, the sound
passes unchanged, 10 ms late; so it does while nobody speaks at the other end. Once its delay is known, the filter looks
at what was played through a window that begins a little before the direct sound, and learns at once from what was heard
lately.

Devices lose sound, and time stamps tell of it late or never: the echo jumps. Once the estimated echo is no longer in
what is recorded, the filter stops learning, the suppressor expects all of it to be left, and the window moves to where
the learned response fits again (echo_shift.py). Time stamps that tell of the jump later change what the delay is
called, but do not move the window.
"""

from collections import deque

import numpy as np
from numpy.typing import NDArray

from conf.audio.echo_delay import DelayFinder
from conf.audio.echo_filter import BLOCK, PARTITIONS, EchoFilter
from conf.audio.echo_shift import REACH, find_shift
from conf.audio.echo_suppressor import HOP, EchoSuppressor
from conf.audio.samples import FULL_SCALE, SAMPLE_RATE, AudioBlock, Samples, to_int16

DELAY_S = HOP / SAMPLE_RATE  # from input to output
HEADROOM = SAMPLE_RATE // 100  # samples of the window before the direct sound: 10 ms

_MIN_HEADROOM = SAMPLE_RATE // 500  # samples
_MAX_HEADROOM = 3 * BLOCK
_HISTORY = 3 * SAMPLE_RATE  # samples of what was played that are kept
_GAP_S = 0.001  # time stamps further apart than this are of another stretch of sound
_MAX_GAP_S = 1.0  # of time stamps, within a stretch
_MAX_WAIT = 4 * BLOCK  # samples of the microphone that wait for what was played meanwhile
_STOPPED_S = 0.1  # a loudspeaker this late has stopped
_FINDER_LAG = 3  # blocks by which the delay finder is late, so that what was played is known
_LEARNED = 75  # blocks of the microphone that are kept to learn from: 1.5 s
_SILENCE_POWER = 1e-7  # of a block that was played, full scale 1: -70 dBFS
_TAIL = PARTITIONS + 30  # blocks after the last sound for which an echo can be heard
_MIN_SHIFT = 0.2  # samples: closer the filter fits
_QUIETER = 0.7  # gain from which somebody has turned the volume down
_SHIFT_BLOCKS = 3  # of what was heard, in which a jump of the echo is looked for
_WRONG_AFTER = 25  # doubtful blocks without one that fits, after which the room is learned again
_MIN_RATIO, _MAX_RATIO = 0.01, 10.0


class EchoCanceller:
    """The echo of one loudspeaker in one microphone."""

    def __init__(self) -> None:
        self._played = _Timeline()
        self._finder = DelayFinder()
        self._filter = EchoFilter()
        self._suppressor = EchoSuppressor()
        self._pending = AudioBlock(0.0, np.zeros(0, np.int16))  # of the microphone
        self._heard: deque[tuple[NDArray[np.float32], int]] = deque(maxlen=_LEARNED)  # blocks and their positions
        self._next: int | None = None  # position of the block that follows
        self._lag = 0  # samples from the start of the window to the microphone's sound
        self._quiet = _TAIL  # blocks since the loudspeaker's last sound
        self._rested = True
        self._power_ratio = 0.0  # of the echo to what was played, roughly
        self._shift: float | None = None  # found in the block before; chance finds none twice
        self._doubtful = 0  # blocks since the last one that fitted

    @property
    def delay_s(self) -> float | None:
        """Return the time from what the loudspeaker takes to its echo, s, or None if there is no echo."""
        return None if self._finder.delay is None else self._finder.delay / SAMPLE_RATE

    def process(self, recorded: AudioBlock, played: AudioBlock | None = None) -> AudioBlock:
        """Return the sound without echo, in multiples of BLOCK samples; the rest waits for the next call.

        recorded : of the microphone, of any length; a gap to the last one's end starts a new stretch
        played : what the loudspeaker played since the last call, on the same clock
        The time stamp returned is that of the capture.
        """
        if played is not None and self._played.append(played):
            self._next = None
        if len(self._pending.samples) and abs(recorded.timestamp - self._pending.end) < _GAP_S:
            recorded = AudioBlock(self._pending.timestamp, np.concatenate([self._pending.samples, recorded.samples]))
        done = self._ready(recorded)
        parts = [
            self._process_block(recorded.timestamp + first / SAMPLE_RATE, recorded.samples[first : first + BLOCK])
            for first in range(0, done, BLOCK)
        ]
        self._pending = AudioBlock(recorded.timestamp + done / SAMPLE_RATE, recorded.samples[done:])
        return AudioBlock(recorded.timestamp - DELAY_S, np.concatenate([np.zeros(0, np.int16), *parts]))

    def _ready(self, recorded: AudioBlock) -> int:
        """Return how many samples of the microphone can be processed, a multiple of BLOCK."""
        count = len(recorded.samples)
        if recorded.end - self._played.end < _STOPPED_S:
            known = round((self._played.end - recorded.timestamp) * SAMPLE_RATE) + self._lag
            count = min(count, max(known, count - _MAX_WAIT))
        return max(0, count) // BLOCK * BLOCK

    def _process_block(self, timestamp: float, samples: Samples) -> Samples:
        position = self._follow(self._played.position(timestamp))
        recorded = samples.astype(np.float32) / np.float32(FULL_SCALE)
        self._heard.append((recorded, position))
        self._find_delay()
        played = self._read_played(position)
        is_silent = float(np.square(played[BLOCK:]).mean()) < _SILENCE_POWER
        self._quiet = self._quiet + 1 if is_silent else 0
        if self._quiet >= _TAIL or self._finder.delay is None:
            self._rested = True
            parts = [self._suppressor.bypass(hop) for hop in recorded.reshape(-1, HOP)]
        else:
            if self._rested:
                self._set_history(position)
                self._rested = False
            parts = self._cancel(recorded, played)
        return to_int16(np.concatenate(parts).astype(np.float64) * FULL_SCALE)

    def _follow(self, position: int) -> int:
        """Return the position of a block, without the jitter of rounding.

        If a device's time stamps jump, the window stays on the sound that follows in the row.
        """
        jump = 0 if self._next is None else position - self._next
        if self._next is not None and abs(jump) <= 1:
            position = self._next
        elif self._next is None or self._finder.delay is None or abs(jump) > _MAX_GAP_S * SAMPLE_RATE:
            self._heard.clear()
        else:
            self._lag += jump
            self._finder.restart(self._finder.delay + jump)
            self._move_heard(jump, len(self._heard))
        self._next = position + BLOCK
        return position

    def _move_heard(self, samples: int, count: int) -> None:
        """Change the positions of the oldest blocks that were heard: their echo has not moved, though the lag has."""
        for index in range(count):
            recorded, position = self._heard[index]
            self._heard[index] = recorded, position + samples

    def _cancel(self, recorded: NDArray[np.float32], played: NDArray[np.float32]) -> list[NDArray[np.float32]]:
        """Return the hops without echo."""
        echo = self._filter.process(recorded, played)
        if self._filter.is_doubtful and self._follow_echo():
            echo = self._filter.process(recorded, self._read_played(self._heard[-1][1]))
        self._doubtful = 0 if self._filter.is_fitting else self._doubtful + self._filter.is_doubtful
        if self._doubtful == _WRONG_AFTER:
            self._learn_again()
        residual_power = np.float32(0.5) * self._filter.residual_power[::2]  # of half the samples
        hops = zip((recorded - echo).reshape(-1, HOP), echo.reshape(-1, HOP), strict=True)
        return [self._suppressor.process(*hop, residual_power) for hop in hops]

    def _follow_echo(self) -> bool:
        """Move the window if the echo has certainly jumped or become quieter; return whether it has."""
        heard = list(self._heard)[-_SHIFT_BLOCKS:]
        if len(heard) < _SHIFT_BLOCKS:
            return False
        count = PARTITIONS * BLOCK + 2 * REACH + _SHIFT_BLOCKS * BLOCK
        first = heard[0][1] - self._lag - PARTITIONS * BLOCK - REACH
        recorded = np.concatenate([block for block, _ in heard])
        shift = find_shift(recorded, self._played.read(first, count), self._filter.response)
        before, self._shift = self._shift, shift.samples if shift else None
        if shift is None or before is None or abs(shift.samples - before) > 1 or self._finder.delay is None:
            return False
        self._shift = None
        has_moved = abs(shift.samples) > _MIN_SHIFT
        if not has_moved and (shift.gain > _QUIETER or self._doubtful < _SHIFT_BLOCKS):
            return False
        self._doubtful = 0
        whole = round(shift.samples)
        # The blocks may be partly from before a jump: they say nothing of the volume, nor do the next two.
        self._filter.change_response(shift.samples - whole, 1.0 if has_moved else shift.gain)
        self._lag += whole
        self._move_heard(whole, len(self._heard) - _SHIFT_BLOCKS)
        self._finder.restart(self._finder.delay + whole)
        self._set_history(heard[-1][1])
        return True

    def _set_history(self, position: int) -> None:
        """Let the filter know what was played before a block."""
        count = (PARTITIONS + 1) * BLOCK
        self._filter.set_history(self._played.read(position - self._lag - count, count))

    def _find_delay(self) -> None:
        """Let the finder hear a block that is some blocks old; move the window to a new delay."""
        recorded, position = self._heard[-min(len(self._heard), 1 + _FINDER_LAG)]
        before = self._finder.delay
        has_changed = self._finder.update(recorded, self._played.read(position, BLOCK))
        delay = self._finder.delay
        if delay is None:
            return
        if has_changed and self._filter.is_fitting:
            self._finder.restart(before)
            return
        if has_changed or not _MIN_HEADROOM <= delay - self._lag <= _MAX_HEADROOM:
            self._lag = max(0, delay - HEADROOM) // BLOCK * BLOCK
            self._learn_again()

    def _learn_again(self) -> None:
        """Learn the room from what was heard lately."""
        heard = [(recorded, self._read_played(position)) for recorded, position in list(self._heard)[:-1]]
        if heard:  # nothing after a gap
            recorded_power, played_power = (
                float(sum(np.square(block[-BLOCK:]).sum() for block in blocks)) for blocks in zip(*heard, strict=True)
            )
            self._power_ratio = min(max(2 * recorded_power / (played_power + 1e-9), _MIN_RATIO), _MAX_RATIO)
        self._reset()
        for recorded, played in heard:
            self._filter.process(recorded, played)

    def _read_played(self, position: int) -> NDArray[np.float32]:
        """Return what was played at the window's start for a block, and the block before."""
        return self._played.read(position - self._lag - BLOCK, 2 * BLOCK)

    def _reset(self) -> None:
        self._filter.reset(self._power_ratio)
        self._suppressor.reset()
        self._doubtful = 0


class _Timeline:
    """What was played, in a row. Positions are samples from the start of the newest stretch."""

    def __init__(self) -> None:
        self._samples = np.zeros(_HISTORY, np.float32)  # a ring
        self._start = 0.0
        self._count = 0  # samples of the stretch

    @property
    def end(self) -> float:
        """Return the time of the sample that would follow, s; long ago before the first."""
        return self._start + self._count / SAMPLE_RATE if self._count else -np.inf

    def append(self, block: AudioBlock, /) -> bool:
        """Add a block; return whether it begins a stretch, with silence before it.

        After a short gap the stretch goes on: its start is later by as much.
        """
        gap = block.timestamp - self.end
        is_new = not -_GAP_S <= gap <= _MAX_GAP_S
        if is_new:
            self._start, self._count = block.timestamp, 0
            self._samples[:] = 0
        elif gap > _GAP_S:
            self._start += gap
        self._write(block.samples)
        return is_new

    def _write(self, samples: Samples) -> None:
        self._count += len(samples)
        kept = samples[-_HISTORY:]
        self._samples[(self._count - len(kept) + np.arange(len(kept))) % _HISTORY] = kept / FULL_SCALE

    def position(self, timestamp: float, /) -> int:
        """Return the position of a time, which may lie outside of the stretch."""
        return round((timestamp - self._start) * SAMPLE_RATE) if self._count else 0

    def read(self, first: int, count: int, /) -> NDArray[np.float32]:
        """Return the samples from a position on, 0 where none are known."""
        positions = first + np.arange(count)
        known = (positions >= max(0, self._count - _HISTORY)) & (positions < self._count)
        return np.where(known, self._samples[positions % _HISTORY], np.float32(0))
