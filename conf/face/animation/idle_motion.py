"""Idle motion: blinks, glances and head sway. A face that does not move at all looks dead.

The motion is a function of a random generator and the time: the same generator gives the same motion, whatever times
are asked for. One eye blinks a few milliseconds after the other (section 3.3 of the thesis).
Source of the numbers: Bentivoglio et al. 1997 (blink rate), Evinger et al. 1991 (time course of blinks), Bahill et al.
1975 (saccades).
"""

import bisect
import math

import numpy as np
from numpy.typing import NDArray

from conf.face.animation.action_units import load_action_units
from conf.face.animation.gaze import gaze_displacements
from conf.face.animation.timed_expression import Envelope, smooth_rise
from conf.face.symmetry import side_weighted

BLINK = Envelope(onset=0.09, hold=0.03, release=0.18)
BLINK_PAUSE = (3.6, 0.5, 1.0)  # seconds: median, standard deviation of the logarithm, minimum
DOUBLE_BLINK = (0.12, 0.35)  # probability that a blink is repeated, and seconds until then
EYE_LAG = (0.004, 0.02)  # seconds between the two eyes
GLANCE_PAUSE = (1.4, 0.6, 0.25)  # as BLINK_PAUSE
GLANCE_DEGREES = (2.4, 1.2)  # standard deviation of yaw and pitch; small, as a listener looks at the viewer
MAX_GLANCE = 0.12  # radians
SACCADE_SECONDS = 0.05
SWAYS = 4  # sine waves added for each component of the head pose
SWAY_HERTZ = (0.05, 0.35)
SWAY_DEGREES = (0.8, 1.6, 0.6)  # amplitude of pitch, yaw, roll
SWAY_SHIFT = 0.004  # amplitude of position, image heights


class IdleMotion:
    """The idle motion of one face."""

    def __init__(self, generator: np.random.Generator, /, *, intensity: float = 1.0) -> None:
        """Start at time 0. intensity : of glances and sway, 0 none, 1 normal; blinks do not depend on it"""
        blinks, glances, sways = generator.spawn(3)
        self._blinks = _BlinkProcess(blinks)
        self._saccades = _SaccadeProcess(glances)
        self._intensity = intensity
        amplitudes = np.array([*np.radians(SWAY_DEGREES), SWAY_SHIFT, SWAY_SHIFT, 0.0])
        self._hertz = SWAY_HERTZ[0] * (SWAY_HERTZ[1] / SWAY_HERTZ[0]) ** sways.random((SWAYS, 6))
        self._phase = sways.uniform(0, 2 * np.pi, (SWAYS, 6))
        self._sway_amplitude = amplitudes * sways.uniform(0.5, 1.0, (SWAYS, 6)) / SWAYS
        self._closed_lids = [side_weighted(load_action_units()[45], side) for side in "lr"]

    def at(self, now: float, /) -> tuple[NDArray[np.float32], NDArray[np.float64]]:
        """Return displacements, (n, 3) FAPU units, and a head pose vector, (6,), to be added at a time from 0 s on."""
        yaw, pitch = self._intensity * self._saccades.at(now)
        displacements = gaze_displacements(yaw, pitch)
        for closed, weight in zip(self._closed_lids, self._blinks.at(now), strict=True):
            displacements += np.float32(weight) * closed
        waves = self._sway_amplitude * np.sin(2 * np.pi * self._hertz * now + self._phase)
        return displacements, self._intensity * waves.sum(axis=0)


class _BlinkProcess:
    """The times of blinks: a list that is extended as needed, always by the same random draws."""

    def __init__(self, generator: np.random.Generator) -> None:
        self._generator = generator
        self._starts: list[float] = []
        self._lags: list[tuple[float, float]] = []  # of the left and the right eye

    def at(self, now: float) -> tuple[float, float]:
        """Return how far the left and the right eye are closed, 0 to 1."""
        while not self._starts or self._starts[-1] <= now:
            self._add()
        end = bisect.bisect_right(self._starts, now)
        recent = range(max(end - 2, 0), end)
        left, right = (
            max((BLINK(now - self._starts[i] - self._lags[i][eye]) for i in recent), default=0.0) for eye in (0, 1)
        )
        return left, right

    def _add(self) -> None:
        pause = _pause(self._generator, BLINK_PAUSE)
        if self._starts and self._generator.random() < DOUBLE_BLINK[0]:
            pause = DOUBLE_BLINK[1]
        self._starts.append((self._starts[-1] if self._starts else 0.0) + pause)
        lag = self._generator.uniform(*EYE_LAG)
        self._lags.append((0.0, lag) if self._generator.random() < 0.5 else (lag, 0.0))


class _SaccadeProcess:
    """The gaze directions between saccades, and their start times."""

    def __init__(self, generator: np.random.Generator) -> None:
        self._generator = generator
        self._starts = [0.0]
        self._directions = [np.zeros(2)]

    def at(self, now: float) -> NDArray[np.float64]:
        """Return (2,) radians: yaw to the subject's left, pitch up."""
        while self._starts[-1] <= now:
            self._starts.append(self._starts[-1] + _pause(self._generator, GLANCE_PAUSE))
            direction = np.radians(self._generator.normal(0.0, GLANCE_DEGREES))
            self._directions.append(direction.clip(-MAX_GLANCE, MAX_GLANCE))
        i = max(bisect.bisect_right(self._starts, now) - 1, 0)
        before = self._directions[max(i - 1, 0)]
        return np.asarray(before + (self._directions[i] - before) * smooth_rise(now - self._starts[i], SACCADE_SECONDS))


def _pause(generator: np.random.Generator, parameters: tuple[float, float, float]) -> float:
    median, deviation, minimum = parameters
    return max(minimum, median * math.exp(deviation * generator.normal()))
