"""Simulated rooms: what a microphone hears of a loudspeaker that stands in the same room.

The response of a shoebox room is the sum of its image sources (Allen, Berkley 1979) for the first 40 ms and, from
there on, noise that decays exponentially, as dense late reflections do (Polack 1988). Walls absorb alike at all
frequencies; their absorption follows from the reverberation time by Sabine's formula.
"""

from dataclasses import dataclass
from functools import cache
from itertools import product

import numpy as np
from numpy.typing import NDArray
from scipy.signal import fftconvolve

from conf.audio.samples import SAMPLE_RATE, Samples, amplitude, to_int16

SPEED_OF_SOUND = 343.0  # m/s
_EARLY_S = 0.04  # image sources up to here
_HALF = 16  # zero crossings of the interpolating sinc to each side
_NOISE_DBFS = -72.0  # of the room and the microphone
_ACTIVE_DB = 40.0  # below the loudest 20 ms a sound counts as a pause


@dataclass(frozen=True)
class Room:
    """A shoebox. size, speaker, microphone : (x, y, z), m; reverberation_s : until the sound has decayed by 60 dB"""

    size: tuple[float, float, float]
    speaker: tuple[float, float, float]
    microphone: tuple[float, float, float]
    reverberation_s: float


ROOMS = {
    "desk": Room((2.6, 3.2, 2.4), (1.1, 0.6, 0.9), (1.3, 1.0, 0.9), 0.2),
    "office": Room((3.5, 4.5, 2.6), (1.2, 0.7, 0.9), (1.8, 1.2, 1.0), 0.35),
    "living": Room((5.2, 6.3, 2.7), (1.0, 1.0, 1.2), (2.2, 2.3, 0.8), 0.5),
}


@dataclass(frozen=True)
class Scene:
    """How loudspeaker and microphone are joined.

    delay_s : from the samples played to the sound at the microphone by the direct path
    later_delay_s, change_s : the delay from a time on, or None
    echo_db : level of the echo over that of the near voice
    drift_ppm : by how much the microphone's clock is slower than the loudspeaker's
    distortion : of the loudspeaker, 0 to 1: tanh(x d) / d for x in full scale after its level is raised to 1
    """

    room: str = "office"
    delay_s: float = 0.06
    echo_db: float = -6.0
    drift_ppm: float = 0.0
    distortion: float = 0.0
    later_delay_s: float | None = None
    change_s: float = 8.0


@cache
def room_response(room: Room, /, *, seed: int = 0) -> NDArray[np.float64]:
    """Return the impulse response, (n,) at SAMPLE_RATE, of unit energy; sample 0 is the direct sound."""
    volume = float(np.prod(room.size))
    x, y, z = room.size
    absorption = min(0.161 * volume / (2 * (x * y + y * z + z * x)) / room.reverberation_s, 0.99)
    reflection = np.sqrt(1 - absorption)
    response = np.zeros(round(room.reverberation_s * SAMPLE_RATE))
    direct = _distance(np.array(room.speaker), room)
    reach = direct + _EARLY_S * SPEED_OF_SOUND
    counts = [int(np.ceil(reach / (2 * length))) for length in room.size]
    for cell in product(*(range(-count, count + 1) for count in counts)):
        for mirror in product((0, 1), repeat=3):
            signs, steps = 1 - 2 * np.array(mirror), np.array(cell)
            distance = _distance(signs * room.speaker + 2 * steps * room.size, room)
            if distance < reach:
                bounces = int(np.abs(steps - mirror).sum() + np.abs(steps).sum())
                at = (distance - direct) / SPEED_OF_SOUND * SAMPLE_RATE
                _add_impulse(response, at, reflection**bounces / distance)
    rng = np.random.default_rng(seed)
    decay = 10 ** (-3 * np.arange(len(response)) / (room.reverberation_s * SAMPLE_RATE))
    early = round(_EARLY_S * SAMPLE_RATE)
    density = np.sqrt((response[early // 2 : early] ** 2).sum() / (decay[early // 2 : early] ** 2).sum())
    response[early:] = density * (rng.normal(size=len(response)) * decay)[early:]
    return response / np.sqrt(response @ response)


def simulate_echo(played: Samples, scene: Scene, /, *, dbfs: float, seed: int = 0) -> NDArray[np.float64]:
    """Return the echo at the microphone, float in int16 units, as long as what was played.

    dbfs : level of the echo while the loudspeaker plays
    """
    sound = played.astype(np.float64)
    if scene.distortion:
        scaled = sound / np.abs(sound).max() * scene.distortion
        sound = np.tanh(scaled) / scene.distortion * np.abs(sound).max()
    echo = fftconvolve(sound, room_response(ROOMS[scene.room], seed=seed))[: len(sound)]
    echo *= amplitude(dbfs) / amplitude(active_dbfs(to_int16(echo)))
    delayed = _delay(echo, scene.delay_s)
    if scene.later_delay_s is not None:
        change = round(scene.change_s * SAMPLE_RATE)
        delayed[change:] = _delay(echo, scene.later_delay_s)[change:]
    return stretch(delayed, scene.drift_ppm) if scene.drift_ppm else delayed


def room_noise(count: int, /, *, seed: int = 0) -> NDArray[np.float64]:
    """Return the noise of the room and the microphone, float in int16 units."""
    return np.random.default_rng(seed).normal(0, amplitude(_NOISE_DBFS), count)


def active_dbfs(samples: Samples, /) -> float:
    """Return the level of a sound without its pauses, dBFS."""
    frames = samples[: len(samples) // 320 * 320].reshape(-1, 320).astype(np.float64)
    powers = (frames**2).mean(axis=1)
    active = powers[powers > powers.max() * 10 ** (-_ACTIVE_DB / 10)]
    return float(10 * np.log10(active.mean() / 32768.0**2))


def stretch(sound: NDArray[np.float64], ppm: float, /) -> NDArray[np.float64]:
    """Return a sound as a clock hears it that is slower by some parts per million; as long as before."""
    positions = np.arange(len(sound)) * (1 + ppm * 1e-6)
    whole = np.floor(positions).astype(np.int64)
    padded = np.concatenate([np.zeros(_HALF - 1), sound, np.zeros(_HALF + 2 + max(0, whole[-1] + 1 - len(sound)))])
    windows = np.lib.stride_tricks.sliding_window_view(padded, 2 * _HALF)[whole]
    offsets = np.arange(2 * _HALF) - _HALF + 1 - (positions - whole)[:, None]
    return np.asarray((windows * np.sinc(offsets) * (0.5 + 0.5 * np.cos(np.pi * offsets / (_HALF + 1)))).sum(axis=1))


def _delay(sound: NDArray[np.float64], delay_s: float) -> NDArray[np.float64]:
    count = round(delay_s * SAMPLE_RATE)
    return np.concatenate([np.zeros(count), sound[: len(sound) - count]])


def _distance(image: NDArray[np.float64], room: Room) -> float:
    return float(np.linalg.norm(image - room.microphone))


def _add_impulse(response: NDArray[np.float64], at: float, height: float) -> None:
    """Add a band-limited impulse between two samples."""
    first = int(np.floor(at)) - _HALF + 1
    indices = np.arange(max(first, 0), min(first + 2 * _HALF, len(response)))
    offsets = indices - at
    response[indices] += height * np.sinc(offsets) * (0.5 + 0.5 * np.cos(np.pi * offsets / (_HALF + 1)))
