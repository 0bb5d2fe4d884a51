"""Play sound slower or faster without changing its pitch: WSOLA, streaming (Verhelst, Roelands 1993).

Output is made in steps of 12 ms. Each cross-fades from the natural continuation of what was played last to the place
near the ideal position whose waveform resembles it best. While the natural continuation itself is near enough it
resembles itself best, so most steps are plain copies and now and then a pitch period is repeated or left out.
"""

import numpy as np
from numpy.typing import NDArray

from conf.audio.samples import SAMPLE_RATE, Samples, to_int16

MIN_SPEED, MAX_SPEED = 0.5, 2.0
_STEP = SAMPLE_RATE * 12 // 1000  # samples of output
_SEARCH = SAMPLE_RATE * 7 // 1000  # samples to each side: together more than a period of 75 Hz
_FADE_IN = 0.5 - 0.5 * np.cos(np.pi * (np.arange(_STEP) + 0.5) / _STEP)


class TimeStretcher:
    """One talker's sound between decoder and mixer. At speed 1 samples pass unchanged and without delay."""

    def __init__(self) -> None:
        self._input = np.zeros(0)
        self._start = 0  # of self._input in the stream, samples
        self._ideal = 0.0  # position in the stream that the output has reached, samples
        self._natural = 0  # position that follows what was copied last
        self._ready = np.zeros(0)  # output made and not yet pulled
        self._ready_speed = 1.0

    @property
    def buffered(self) -> float:
        """Return how many input samples are waiting to be heard."""
        return self._end - self._ideal + len(self._ready) * self._ready_speed

    def push(self, samples: Samples, /) -> None:
        """Append input."""
        self._input = np.concatenate([self._input, samples.astype(np.float64)])

    def missing(self, count: int, speed: float = 1.0) -> int:
        """Return how many samples must be pushed before `pull(count, speed)` can return all of them."""
        count -= len(self._ready)
        if count <= 0:
            return 0
        if speed == 1.0:
            return max(0, self._natural + count - self._end)
        before = -(-count // _STEP) - 1  # steps before the last
        last = self._ideal + before * _STEP * speed + _SEARCH  # where the last may begin
        natural = max(self._natural, last + (1 - speed) * _STEP if before else 0.0)
        return max(0, int(max(last, natural)) + 2 + _STEP - self._end)

    def pull(self, count: int, speed: float = 1.0) -> Samples:
        """Return up to count samples: input played at a speed; fewer if more input is needed.

        speed : 1.1 takes 10 % less time than the input did; from MIN_SPEED to MAX_SPEED
        """
        if not MIN_SPEED <= speed <= MAX_SPEED:
            raise ValueError(f"speed must be from {MIN_SPEED} to {MAX_SPEED}")
        parts = [self._ready[:count]]
        self._ready = self._ready[count:]
        count -= len(parts[0])
        if speed == 1.0:
            parts.append(self._copy(count))
        while speed != 1.0 and count > 0 and self._has_input():
            step = self._stretch(speed)
            parts.append(step[:count])
            self._ready = step[count:]
            count -= len(parts[-1])
        self._forget()
        return to_int16(np.concatenate(parts))

    @property
    def _end(self) -> int:
        return self._start + len(self._input)

    def _copy(self, count: int) -> NDArray[np.float64]:
        """Return the natural continuation."""
        copied = self._slice(self._natural, min(count, self._end - self._natural))
        self._natural += len(copied)
        self._ideal += len(copied)
        return copied

    def _has_input(self) -> bool:
        return max(round(self._ideal) + _SEARCH + 1, self._natural) + _STEP <= self._end

    def _stretch(self, speed: float) -> NDArray[np.float64]:
        """Return the next step of output."""
        natural = self._slice(self._natural, _STEP)
        first = max(round(self._ideal) - _SEARCH, self._start)
        candidates = self._slice(first, round(self._ideal) + _SEARCH + _STEP - first)
        best = first + _most_similar(natural, candidates)
        step = natural + _FADE_IN * (self._slice(best, _STEP) - natural)
        self._natural = best + _STEP
        self._ideal += speed * _STEP
        self._ready_speed = speed
        return step

    def _slice(self, position: int, count: int) -> NDArray[np.float64]:
        return self._input[position - self._start : position - self._start + count]

    def _forget(self) -> None:
        """Drop input that no later search can reach."""
        unused = min(self._natural, int(self._ideal)) - _SEARCH - 1 - self._start
        if unused > 0:
            self._input = self._input[unused:]
            self._start += unused


def _most_similar(template: NDArray[np.float64], signal: NDArray[np.float64]) -> int:
    """Return the offset in a signal at which the normalised cross-correlation with a template is highest."""
    products = np.correlate(signal, template, mode="valid")
    sums = np.concatenate([[0.0], np.cumsum(signal * signal)])
    energies = sums[len(template) :] - sums[: -len(template)]
    return int(np.argmax(products / np.sqrt(np.maximum(energies, 1.0))))
