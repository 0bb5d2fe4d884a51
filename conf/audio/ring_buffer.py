"""Samples between two threads, the only object that an audio callback touches.

One thread writes, one reads, nobody waits: a callback that waits for a lock held by a busy thread loses sound. Both
positions only grow and each is set by one side, after the samples are copied.
"""

import numpy as np

from conf.audio.samples import SAMPLE_RATE, Samples, to_int16

_FADE = SAMPLE_RATE // 200  # samples of the fades around an underrun, 5 ms


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


class PlaybackBuffer(RingBuffer):
    """A ring buffer that always has something to play: it fades out when it runs empty and in when sound returns.

    underruns : how often it ran empty after sound had come
    missing : samples played without sound in them since the first underrun
    """

    def __init__(self, capacity: int) -> None:
        super().__init__(capacity)
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
        rising = np.minimum(1.0, self._gain + np.arange(1, len(sound) + 1) / _FADE)
        self._gain = float(rising[-1]) if len(sound) else self._gain
        falling = np.maximum(0.0, self._gain - np.arange(1, short + 1) / _FADE)
        self._gain = float(falling[-1]) if short else self._gain
        return to_int16(np.concatenate([rising * sound, falling * self._last]))
