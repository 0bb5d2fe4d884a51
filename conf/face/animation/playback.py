"""Playing a recorded motion: a clock that can be stopped and sped up, and what lies between two frames.

The clock is told the time (`now`, seconds); it reads none. Between frames each number follows a monotone cubic: it
passes through every frame, smoothly, and never overshoots a frame's value, so that a closed eye does not close
further on its way. At a frame where the motion turns back, it rests.
Source: Fritsch, Carlson 1980; Fritsch, Butland 1984 (slopes).
"""

import math

import numpy as np
from numpy.typing import NDArray

from conf.face.formats.dpc import MotionClip

SPEEDS = (0.1, 4.0)


class PlaybackClock:
    """Where in a recording of a given duration the playing is."""

    def __init__(self, duration: float, /, *, loop: bool = False) -> None:
        """Stand at the beginning. duration : seconds. Raises ValueError unless it is finite and not negative."""
        if not (math.isfinite(duration) and duration >= 0):
            raise ValueError(f"duration must be finite and not negative, got {duration}")
        self.duration = duration
        self.loop = loop
        self._speed = 1.0
        self._playing = False
        self._anchor = 0.0  # position at time `_since`
        self._since = 0.0

    @property
    def speed(self) -> float:
        """How many seconds of the recording pass in one."""
        return self._speed

    def is_playing(self, now: float, /) -> bool:
        """Tell whether the position is moving: a recording that has come to its end stands still."""
        return self._playing and (self.loop or self.position(now) < self.duration)

    def position(self, now: float, /) -> float:
        """Return the seconds from the recording's beginning, 0 to its duration."""
        if not self._playing:
            return self._anchor
        position = self._anchor + max(0.0, now - self._since) * self._speed
        if self.loop and self.duration > 0:
            return position % self.duration
        return min(position, self.duration)

    def start(self, now: float, /) -> None:
        """Play from the beginning."""
        self._settle(0.0, now)
        self._playing = True

    def pause(self, now: float, /) -> None:
        """Stand still here."""
        self._settle(self.position(now), now)
        self._playing = False

    def resume(self, now: float, /) -> None:
        """Play on from here; from the beginning if the end was reached."""
        position = self.position(now)
        self._settle(0.0 if position >= self.duration and not self.loop else position, now)
        self._playing = True

    def stop(self, now: float, /) -> None:
        """Stand still at the beginning."""
        self._settle(0.0, now)
        self._playing = False

    def seek(self, position: float, now: float, /) -> None:
        """Go to a position in seconds, at most the duration, playing or not as before."""
        self._settle(min(max(position, 0.0), self.duration), now)

    def step(self, frames: int, fps: float, now: float, /) -> None:
        """Stand still that many frames on, or back: on a frame, not between two."""
        frame = (
            math.floor(self.position(now) * fps + 1e-6) if frames > 0 else math.ceil(self.position(now) * fps - 1e-6)
        )
        self.pause(now)
        self.seek((frame + frames) / fps, now)

    def set_speed(self, speed: float, now: float, /) -> None:
        """Play faster or slower from here on, within SPEEDS."""
        self._settle(self.position(now), now)
        self._speed = min(max(speed, SPEEDS[0]), SPEEDS[1])

    def _settle(self, position: float, now: float) -> None:
        self._anchor, self._since = position, now


def duration_of(motion: MotionClip, /) -> float:
    """Return the seconds from a motion's first frame to its last."""
    return (len(motion.displacements) - 1) / motion.fps


def displacements_at(motion: MotionClip, position: float, /) -> NDArray[np.float32]:
    """Return the (n, 3) float32 displacements of a motion at a position in seconds, in the motion's units."""
    return interpolate_frames(motion.displacements, position * motion.fps).astype(np.float32)


def pose_at(motion: MotionClip, position: float, /) -> NDArray[np.float64] | None:
    """Return the (6,) head pose of a motion at a position in seconds, or None if it has none."""
    return None if motion.poses is None else interpolate_frames(motion.poses, position * motion.fps)


def interpolate_frames(frames: NDArray[np.floating], position: float, /) -> NDArray[np.float64]:
    """Interpolate frames at a place between them.

    frames : (N, ...) one a unit of place
    place : 0 the first to N - 1 the last; beyond, the first or last frame
    Returns (...) float64.
    """
    last = len(frames) - 1
    position = min(max(position, 0.0), float(last))
    i = min(int(position), max(last - 1, 0))
    before, here, there, after = (np.asarray(frames[min(max(j, 0), last)], np.float64) for j in range(i - 1, i + 3))
    rise = there - here
    slope_here, slope_there = _slope(here - before, rise), _slope(rise, after - there)
    t = position - i
    bend = (slope_here - rise) * (1 - t) + (rise - slope_there) * t
    return np.asarray(here + t * rise + t * (1 - t) * bend)


def _slope(before: NDArray[np.float64], after: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the slope at a frame from the rises on its two sides: their harmonic mean, 0 where the motion turns."""
    product = np.maximum(before * after, 0.0)
    total = before + after
    return np.where(product > 0, 2 * product / np.where(total == 0, 1.0, total), 0.0)
