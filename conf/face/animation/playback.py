"""Playback of a recorded motion: a clock with pause and speed, and interpolation between frames.

The clock is passed the time (`now`, seconds). Each number is interpolated by a monotone cubic: it passes through every
frame, is smooth and never overshoots, so that a closed eye does not close further between two frames. Its slope is 0 at
a local extremum.
Source: Fritsch, Carlson 1980; Fritsch, Butland 1984 (slopes).
"""

import math

import numpy as np
from numpy.typing import NDArray

from conf.face.formats.dpc import MotionClip

SPEEDS = (0.1, 4.0)  # minimum and maximum


class PlaybackClock:
    """The playback position in a recording of a given duration."""

    def __init__(self, duration: float, /, *, loop: bool = False) -> None:
        """Stop at the start. duration : seconds. Raises ValueError unless it is finite and not negative."""
        if not (math.isfinite(duration) and duration >= 0):
            raise ValueError(f"duration must be finite and not negative, got {duration}")
        self.duration = duration
        self.loop = loop
        self.speed = 1.0  # seconds of the recording per second
        self._playing = False
        self._anchor = 0.0  # position at time `_since`
        self._since = 0.0

    def is_playing(self, now: float, /) -> bool:
        """Return whether the position advances: it does not at the end of a recording."""
        return self._playing and (self.loop or self.position(now) < self.duration)

    def position(self, now: float, /) -> float:
        """Return the position in seconds, 0 to the duration."""
        if not self._playing:
            return self._anchor
        position = self._anchor + max(0.0, now - self._since) * self.speed
        if self.loop and self.duration > 0:
            return position % self.duration
        return min(position, self.duration)

    def start(self, now: float, /) -> None:
        """Play from the start."""
        self._set_position(0.0, now)
        self._playing = True

    def pause(self, now: float, /) -> None:
        """Stop at the current position."""
        self._set_position(self.position(now), now)
        self._playing = False

    def resume(self, now: float, /) -> None:
        """Play from the current position, or from the start if it is the end."""
        position = self.position(now)
        self._set_position(0.0 if position >= self.duration and not self.loop else position, now)
        self._playing = True

    def stop(self, now: float, /) -> None:
        """Stop at the start."""
        self._set_position(0.0, now)
        self._playing = False

    def seek(self, position: float, now: float, /) -> None:
        """Go to a position in seconds, limited to the recording, without starting or stopping."""
        self._set_position(min(max(position, 0.0), self.duration), now)

    def step(self, frames: int, fps: float, now: float, /) -> None:
        """Stop on the frame that many frames later, or earlier if negative."""
        position = self.position(now) * fps
        frame = math.floor(position + 1e-6) if frames > 0 else math.ceil(position - 1e-6)
        self.pause(now)
        self.seek((frame + frames) / fps, now)

    def set_speed(self, speed: float, now: float, /) -> None:
        """Set the speed, limited to SPEEDS, from now on."""
        self._set_position(self.position(now), now)
        self.speed = min(max(speed, SPEEDS[0]), SPEEDS[1])

    def _set_position(self, position: float, now: float) -> None:
        self._anchor, self._since = position, now


def duration_of(motion: MotionClip, /) -> float:
    """Return the seconds from a motion's first frame to its last one."""
    return (len(motion.displacements) - 1) / motion.fps


def displacements_at(motion: MotionClip, position: float, /) -> NDArray[np.float32]:
    """Return the (n, 3) float32 displacements of a motion at a position in seconds, in the motion's units."""
    return interpolate_frames(motion.displacements, position * motion.fps).astype(np.float32)


def pose_at(motion: MotionClip, position: float, /) -> NDArray[np.float64] | None:
    """Return the (6,) head pose of a motion at a position in seconds, or None if it has none."""
    return None if motion.poses is None else interpolate_frames(motion.poses, position * motion.fps)


def interpolate_frames(frames: NDArray[np.floating], position: float, /) -> NDArray[np.float64]:
    """Return (...) float64: the frames interpolated at a position between them.

    frames : (N, ...)
    position : in frames, 0 to N - 1; values beyond yield the first or last frame
    """
    last = len(frames) - 1
    position = min(max(position, 0.0), float(last))
    i = min(int(position), max(last - 1, 0))
    before, start, end, after = (np.asarray(frames[min(max(j, 0), last)], np.float64) for j in range(i - 1, i + 3))
    rise = end - start
    start_slope, end_slope = _slope(start - before, rise), _slope(rise, after - end)
    t = position - i
    bend = (start_slope - rise) * (1 - t) + (rise - end_slope) * t
    return np.asarray(start + t * rise + t * (1 - t) * bend)


def _slope(before: NDArray[np.float64], after: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the slope at a frame: the harmonic mean of the differences on its two sides, 0 at an extremum."""
    product = np.maximum(before * after, 0.0)
    total = before + after
    return np.where(product > 0, 2 * product / np.where(total == 0, 1.0, total), 0.0)
