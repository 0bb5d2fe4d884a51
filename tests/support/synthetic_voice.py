"""Sounds that a voice codec takes for speech: a buzzing larynx through three formants, in syllables."""

import numpy as np
from numpy.typing import NDArray

from conf.audio.samples import SAMPLE_RATE, Samples, to_int16

_VOWELS = ((730, 1090, 2440), (270, 2290, 3010), (300, 870, 2240), (530, 1840, 2480))  # a i u e; Peterson, Barney 1952
_BANDWIDTHS = (80, 100, 150)


def tone(hertz: float, seconds: float, /, *, amplitude: float = 8000) -> Samples:
    """Return a sine of an amplitude in int16 units."""
    return to_int16(amplitude * np.sin(2 * np.pi * hertz * np.arange(round(seconds * SAMPLE_RATE)) / SAMPLE_RATE))


def vowel(number: int, seconds: float, /, *, pitch: float = 120, amplitude: float = 8000) -> Samples:
    """Return a vowel of constant pitch whose largest sample has an amplitude in int16 units."""
    times = np.arange(round(seconds * SAMPLE_RATE)) / SAMPLE_RATE
    sound = np.zeros(len(times))
    for harmonic in range(1, int(0.45 * SAMPLE_RATE / pitch)):
        frequency = harmonic * pitch
        response = 1 / harmonic + 0j
        for formant, bandwidth in zip(_VOWELS[number % len(_VOWELS)], _BANDWIDTHS, strict=True):
            response *= formant**2 / (formant**2 - frequency**2 + 1j * bandwidth * frequency)
        sound += abs(response) * np.cos(2 * np.pi * frequency * times + np.angle(response))
    return to_int16(amplitude * sound / np.abs(sound).max())


def speech(seconds: float, /, *, seed: int = 0, amplitude: float = 8000) -> Samples:
    """Return syllables of 120 to 250 ms, each with attack and decay, between short pauses."""
    rng = np.random.default_rng(seed)
    wanted = round(seconds * SAMPLE_RATE)
    parts: list[NDArray[np.float64]] = []
    while sum(map(len, parts)) < wanted:
        syllable = vowel(int(rng.integers(4)), rng.uniform(0.12, 0.25), pitch=rng.uniform(90, 220), amplitude=amplitude)
        edge = np.hanning(2 * SAMPLE_RATE // 50)
        envelope = np.ones(len(syllable))
        envelope[: len(edge) // 2], envelope[-len(edge) // 2 :] = edge[: len(edge) // 2], edge[len(edge) // 2 :]
        parts += [syllable * envelope, np.zeros(int(rng.integers(200, 1500)))]
    return to_int16(np.concatenate(parts)[:wanted])


def noise(seconds: float, dbfs: float, /, *, seed: int = 0) -> Samples:
    """Return white noise of a level in dB below full scale."""
    rng = np.random.default_rng(seed)
    return to_int16(rng.normal(0, 32768 * 10 ** (dbfs / 20), round(seconds * SAMPLE_RATE)))


def max_jump(samples: Samples) -> int:
    """Return the largest difference of neighbouring samples: what a click raises."""
    return int(np.abs(np.diff(samples.astype(np.int64))).max(initial=0))


def pitch_hz(samples: Samples, low: float = 60, high: float = 400) -> float:
    """Return the frequency at which the autocorrelation is highest."""
    values = samples.astype(np.float64) - samples.mean()
    size = 1 << (2 * len(values)).bit_length()
    power = np.abs(np.fft.rfft(values, size)) ** 2
    correlation = np.fft.irfft(power)
    first, last = int(SAMPLE_RATE / high), int(SAMPLE_RATE / low)
    lag = first + int(np.argmax(correlation[first:last]))
    before, at, after = correlation[lag - 1 : lag + 2]
    return SAMPLE_RATE / (lag + 0.5 * (before - after) / (before - 2 * at + after))


def whisper(seconds: float, /, *, seed: int = 0, dbfs: float = -26) -> Samples:
    """Return syllables of noise with the slope of speech, 6 dB an octave, and a level in dB below full scale."""
    rng = np.random.default_rng(seed)
    count = round(seconds * SAMPLE_RATE)
    hertz = np.fft.rfftfreq(count, 1 / SAMPLE_RATE)
    slope = np.where(hertz > 100, 100 / np.maximum(hertz, 100), 0)
    sound = np.fft.irfft(slope * np.fft.rfft(rng.normal(size=count)), count)
    peaks = rng.uniform(0.2, 1, int(seconds * 5) + 2)  # five syllables a second
    points = np.ravel([[peak, 0.02] for peak in peaks])
    sound *= np.interp(np.arange(count) / SAMPLE_RATE * 10, np.arange(len(points)), points)
    return to_int16(sound * (32768 * 10 ** (dbfs / 20) / np.sqrt(np.mean(sound**2))))
