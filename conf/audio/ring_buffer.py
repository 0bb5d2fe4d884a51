"""Samples between two threads, the only object that an audio callback touches.

One thread writes, one reads, nobody waits: a callback that waits for a lock held by a busy thread loses sound. Both
positions only grow and each is set by one side, after the samples are copied.
"""

from collections import deque

import numpy as np

from conf.audio.samples import SAMPLE_RATE, Samples, to_int16

_FADE_S = 0.005  # of the fades around an underrun


class RingBuffer:
    """A queue of samples of fixed capacity.

    dropped : samples that found no room
    """

    def __init__(self, capacity: int) -> None:
        self._samples = np.zeros(capacity, np.int16)
        self._written = 0
        self._read = 0
        self.dropped = 0

    def __len__(self) -> int:
        return self._written - self._read

    def write(self, samples: Samples, /) -> int:
        """Append samples and return how many found room; the rest are counted in `dropped`."""
        capacity = len(self._samples)
        count = min(len(samples), capacity - len(self))
        start = self._written % capacity
        first = min(count, capacity - start)
        self._samples[start : start + first] = samples[:first]
        self._samples[: count - first] = samples[first:count]
        self._written += count
        self.dropped += len(samples) - count
        return count

    def read(self, count: int, /) -> Samples:
        """Return and remove the oldest samples, up to count."""
        capacity = len(self._samples)
        count = min(count, len(self))
        start = self._read % capacity
        first = min(count, capacity - start)
        samples = np.concatenate([self._samples[start : start + first], self._samples[: count - first]])
        self._read += count
        return samples


class CaptureBuffer(RingBuffer):
    """A ring buffer that keeps the blocks it was filled with and when each was complete."""

    def __init__(self, capacity: int) -> None:
        super().__init__(capacity)
        self._ends: deque[tuple[int, float]] = deque()  # samples and time of each block

    def write_block(self, samples: Samples, end: float) -> None:
        """Append a block whose last sample was captured at a time, s, if there is room for all of it."""
        if len(self) + len(samples) > len(self._samples):
            self.dropped += len(samples)
            return
        self.write(samples)
        self._ends.append((len(samples), end))

    def read_blocks(self) -> list[tuple[Samples, float]]:
        """Return and remove all complete blocks, each with the time of its end."""
        return [(self.read(count), end) for count, end in iter(self._next_end, None)]

    def _next_end(self) -> tuple[int, float] | None:
        return self._ends.popleft() if self._ends else None


class PlaybackBuffer(RingBuffer):
    """A ring buffer that always has something to play: it fades out when it runs empty and in when sound returns.

    underruns : how often it ran empty after sound had come
    missing : samples played without sound in them since the first underrun
    """

    def __init__(self, capacity: int, *, rate: int = SAMPLE_RATE) -> None:
        super().__init__(capacity)
        self._fade = round(_FADE_S * rate)
        self.underruns = 0
        self.missing = 0
        self._last = 0  # sample, before its gain
        self._gain = 0.0  # of the last sample, 0 to 1

    def pull(self, count: int, /) -> Samples:
        """Return exactly count samples."""
        sound = self.read(count)
        short = count - len(sound)
        if short and (len(sound) or self._gain == 1.0):
            self.underruns += 1
        if self.underruns:
            self.missing += short
        if len(sound):
            self._last = int(sound[-1])
        if not short and self._gain == 1.0:
            return sound
        rising = np.minimum(1.0, self._gain + np.arange(1, len(sound) + 1) / self._fade)
        self._gain = float(rising[-1]) if len(sound) else self._gain
        falling = np.maximum(0.0, self._gain - np.arange(1, short + 1) / self._fade)
        self._gain = float(falling[-1]) if short else self._gain
        return to_int16(np.concatenate([rising * sound, falling * self._last]))
