"""Expressions with an envelope in time, and the blending of several motions.

The two sides of a face do not start together (section 3.3 of the thesis): the right one starts later.
"""

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_INDEX, control_point_indices
from conf.face.interpolation import smoothstep
from conf.face.symmetry import side_weighted

SIDE_LAG = 0.03  # seconds
LIDS_CLOSED = -1400.0  # upper minus lower lid, FAPU units: the sculpted blink, around the eyeball, reaches -1384
# Parts of the face that are blended separately: the mouth of joy may be present already, but not its eyes.
PARTS = [
    control_point_indices("inner_lip", "outer_lip", "cupids", "chin"),
    control_point_indices("eye", "pupil"),
    control_point_indices("brow"),
    control_point_indices("cheek", "nose", "nostril"),
]
LIDS = [(CONTROL_POINT_INDEX[f"eyelid_upper_{side}"], CONTROL_POINT_INDEX[f"eyelid_lower_{side}"]) for side in "lr"]


@dataclass(frozen=True)
class Envelope:
    """An intensity over time, with a smooth rise and fall.

    onset, hold, release : seconds of rise, hold and fall; hold may be infinite
    intensity : during the hold
    """

    onset: float = 0.4
    hold: float = 1.5
    release: float = 0.8
    intensity: float = 1.0

    def __post_init__(self) -> None:
        if not (0 <= self.onset < math.inf and 0 <= self.hold and 0 <= self.release < math.inf):
            raise ValueError(f"onset, hold and release must not be negative, nor onset and release infinite: {self}")
        if not math.isfinite(self.intensity):
            raise ValueError(f"intensity must be finite, got {self.intensity}")

    def __call__(self, elapsed: float, /) -> float:
        """Return the intensity at a time in seconds since the start; 0 before it and after the end."""
        falling = elapsed - self.onset - self.hold
        if falling > 0:
            return self.intensity * (1 - smooth_rise(falling, self.release))
        return self.intensity * smooth_rise(elapsed, self.onset)

    @property
    def duration(self) -> float:
        """Seconds from start to end."""
        return self.onset + self.hold + self.release


@dataclass(frozen=True)
class TimedExpression:
    """One expression, played once.

    displacements : (n, 3) float32, FAPU units, at intensity 1
    start : seconds, on the clock of `at`
    released_at : seconds; from then on it fades, in addition to the envelope
    """

    displacements: NDArray[np.float32]
    start: float
    envelope: Envelope = Envelope()
    released_at: float = math.inf
    name: str = ""

    def at(self, now: float, /) -> NDArray[np.float32]:
        """Return the (n, 3) float32 displacements, FAPU units, at a time in seconds."""
        left, right = (self._intensity(now - lag) for lag in (0.0, SIDE_LAG))
        total = left * side_weighted(self.displacements, "l") + right * side_weighted(self.displacements, "r")
        return total.astype(np.float32)

    def is_finished(self, now: float, /) -> bool:
        """Return whether the expression has ended."""
        end = min(self.start + self.envelope.duration, self.released_at + self.envelope.release)
        return now - SIDE_LAG >= end

    def released(self, now: float, /) -> "TimedExpression":
        """Return the same expression, fading from now on."""
        return replace(self, released_at=min(now, self.released_at))

    def _intensity(self, now: float) -> float:
        fade = 1 - smooth_rise(now - self.released_at, self.envelope.release) if now > self.released_at else 1.0
        return self.envelope(now - self.start) * fade


def smooth_rise(elapsed: float, length: float, /) -> float:
    """Return a smooth rise from 0 at elapsed 0 to 1 at elapsed = length; a step if length is 0."""
    if length <= 0:
        return float(elapsed >= 0)
    return float(smoothstep(elapsed / length))


def blend_without_doubling(motion: NDArray[np.floating], expression: NDArray[np.floating], /) -> NDArray[np.float32]:
    """Return motion plus expression, (n, 3) float32 in FAPU units, without what the motion already has of it.

    A smile over a smile is as broad as the broader of the two, not as their sum.
    """
    added = np.array(expression, np.float32)
    for part in PARTS:
        energy = float((added[part] ** 2).sum())
        present = float((motion[part] * added[part]).sum()) / energy if energy else 0.0
        added[part] *= 1.0 - min(max(present, 0.0), 1.0)
    return add_motions(motion, added)


def add_motions(*motions: NDArray[np.floating]) -> NDArray[np.float32]:
    """Return the sum of motions, (n, 3) float32 in FAPU units, with the lids not closed beyond LIDS_CLOSED."""
    total = np.sum([np.asarray(motion, np.float32) for motion in motions], axis=0)
    for upper, lower in LIDS:
        total[upper, 1] = max(total[upper, 1], total[lower, 1] + LIDS_CLOSED)
    return np.asarray(total, np.float32)
