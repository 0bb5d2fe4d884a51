"""What a face does when it does nothing: blink, glance, sway. A face that holds quite still looks dead.

Everything follows from a random generator and the time: the same generator gives the same life, whenever and however
often it is asked. One eye blinks a few milliseconds after the other (section 3.3 of the thesis).
Source for the figures: Bentivoglio et al. 1997 (blinks at rest), Evinger et al. 1991 (their course), Bahill et al.
1975 (saccades).
"""

import bisect
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from conf.face.animation.action_units import load_action_units
from conf.face.animation.gaze import gaze_displacements
from conf.face.animation.timed_expression import Envelope, smooth_rise
from conf.face.symmetry import side_weighted

BLINK = Envelope(onset=0.09, hold=0.03, release=0.18)
BLINK_PAUSE = (3.6, 0.5, 1.0)  # seconds: median, spread of the logarithm, least
DOUBLE_BLINK = (0.12, 0.35)  # how many blinks come twice, and after how many seconds
EYE_LAG = (0.004, 0.02)  # seconds between the two eyes
GLANCE_PAUSE = (1.4, 0.6, 0.25)
GLANCE_DEGREES = (2.4, 1.2)  # spread sideways, up and down; a face that listens looks at the viewer
SACCADE_SECONDS = 0.05
SWAYS = 4  # waves that make up a head's movement
SWAY_HERTZ = (0.05, 0.35)
SWAY_DEGREES = (0.8, 1.6, 0.6)  # amplitude of pitch, yaw, roll
SWAY_SHIFT = 0.004  # amplitude of position, picture heights


@dataclass(frozen=True)
class IdlePose:
    """What to add to a face at one moment.

    displacements : (n, 3) float32, FAPU units
    pose : (6,) float64 to add to a head pose's vector
    """

    displacements: NDArray[np.float32]
    pose: NDArray[np.float64]


class IdleMotion:
    """The small movements of one face."""

    def __init__(self, generator: np.random.Generator, /, *, intensity: float = 1.0) -> None:
        """Begin at time 0. amount : 0 no glances and sways, 1 as usual; blinks come anyhow."""
        blinks, glances, sways = generator.spawn(3)
        self._blinks = _Blinks(blinks)
        self._glances = _SaccadeProcess(glances)
        self._amount = intensity
        amplitudes = np.array([*np.radians(SWAY_DEGREES), SWAY_SHIFT, SWAY_SHIFT, 0.0])
        self._hertz = SWAY_HERTZ[0] * (SWAY_HERTZ[1] / SWAY_HERTZ[0]) ** sways.random((SWAYS, 6))
        self._phase = sways.uniform(0, 2 * np.pi, (SWAYS, 6))
        self._sway_amplitude = amplitudes * sways.uniform(0.5, 1.0, (SWAYS, 6)) / SWAYS
        self._shut = [side_weighted(load_action_units()[45], side) for side in "lr"]

    def at(self, now: float, /) -> IdlePose:
        """Return what the face does at a time in seconds, 0 or later."""
        yaw, pitch = self._amount * self._glances.at(now)
        displacements = gaze_displacements(yaw, pitch)
        for shut, strength in zip(self._shut, self._blinks.at(now), strict=True):
            displacements += np.float32(strength) * shut
        waves = self._sway_amplitude * np.sin(2 * np.pi * self._hertz * now + self._phase)
        return IdlePose(displacements, self._amount * waves.sum(axis=0))


class _Blinks:
    """When the eyes close: a list that grows as time goes on, always by the same draws."""

    def __init__(self, generator: np.random.Generator) -> None:
        self._generator = generator
        self._starts: list[float] = []
        self._lags: list[tuple[float, float]] = []  # of the left and the right eye

    def at(self, now: float) -> tuple[float, float]:
        """Return how far the left and the right eye are shut, 0 to 1."""
        while not self._starts or self._starts[-1] <= now:
            self._add()
        recent = range(max(bisect.bisect_right(self._starts, now) - 2, 0), bisect.bisect_right(self._starts, now))
        left, right = (
            max((BLINK(now - self._starts[i] - self._lags[i][eye]) for i in recent), default=0.0) for eye in (0, 1)
        )
        return left, right

    def _add(self) -> None:
        pause = _pause(self._generator, BLINK_PAUSE)
        share, again = DOUBLE_BLINK
        if self._starts and self._generator.random() < share:
            pause = again
        self._starts.append((self._starts[-1] if self._starts else 0.0) + pause)
        lag = self._generator.uniform(*EYE_LAG)
        self._lags.append((0.0, lag) if self._generator.random() < 0.5 else (lag, 0.0))


class _SaccadeProcess:
    """Where the eyes rest, and since when."""

    def __init__(self, generator: np.random.Generator) -> None:
        self._generator = generator
        self._starts = [0.0]
        self._aims = [np.zeros(2)]

    def at(self, now: float) -> NDArray[np.float64]:
        """Return (2,) radians: yaw to the subject's left, pitch up."""
        while self._starts[-1] <= now:
            self._starts.append(self._starts[-1] + _pause(self._generator, GLANCE_PAUSE))
            self._aims.append(np.radians(self._generator.normal(0.0, GLANCE_DEGREES)).clip(-0.12, 0.12))
        i = max(bisect.bisect_right(self._starts, now) - 1, 0)
        before = self._aims[max(i - 1, 0)]
        return np.asarray(before + (self._aims[i] - before) * smooth_rise(now - self._starts[i], SACCADE_SECONDS))


def _pause(generator: np.random.Generator, figures: tuple[float, float, float]) -> float:
    median, spread, least = figures
    return max(least, median * math.exp(spread * generator.normal()))
