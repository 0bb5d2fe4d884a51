"""The jitter buffer: frames arrive irregularly and are played out at their deadlines.

Strategy. The playout clock says which capture time is due. Frames are not counted: one that is lost is absent when the
playhead passes, so that a loss never stops playout.

Between two frames the playhead interpolates. Furrows, which arrive as steps, are eased over EASE_S. After the newest it
holds, and after HOLD_S fades to the neutral face, so that a dead link does not freeze a grimace.
"""

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from conf.protocol.messages import MotionFrame
from conf.protocol.stream_clocks import PlayoutClock

HOLD_S = 1.5
FADE_S = 1.0
KEPT_S = 2.0  # of frames behind the playhead
MAX_FRAMES = 256  # bounds the memory whatever a peer sends
MAX_INTERPOLATION_S = 0.25  # a longer gap was a still face: the motion belongs to its end
EASE_S = 0.2  # in which furrows change from one level to the next


@dataclass(frozen=True)
class PlayoutFrame:
    """The motion to draw.

    frame : interpolated; its timestamp is the playhead on the sender's clock
    age_s : seconds since the playhead passed the newest frame, 0 while there are frames ahead
    neutral_blend : 0 for the sender's motion, 1 when it has faded to the neutral face
    """

    frame: MotionFrame
    age_s: float
    neutral_blend: float


class JitterBuffer:
    """Order frames by capture time and play each out at its deadline.

    clock : when each frame is due; shared with the voice of the same sender
    late : frames that arrived after their deadline
    playhead : newest timestamp played out, on the sender's clock
    """

    def __init__(self, clock: PlayoutClock | None = None) -> None:
        self.clock = clock or PlayoutClock()
        self.late = 0
        self.playhead = -np.inf
        self._restarts = self.clock.restarts
        self._frames: list[MotionFrame] = []  # by timestamp

    @property
    def newest(self) -> float | None:
        """The timestamp of the newest frame, None if there is none."""
        return self._frames[-1].timestamp if self._frames else None

    def add(self, frame: MotionFrame, now: float) -> None:
        """Insert a frame that arrives at `now`, and adapt the playout delay to its lateness."""
        self.clock.on_arrival(frame.timestamp, now)
        self._drop_frames_of_an_old_clock()
        if frame.timestamp <= self.playhead:
            self.late += 1
        at = bisect_right(self._frames, frame.timestamp, key=lambda f: f.timestamp)
        if at and self._frames[at - 1].timestamp == frame.timestamp:
            return
        self._frames.insert(at, frame)
        del self._frames[:-MAX_FRAMES]

    def repeat_until(self, timestamp: float, now: float) -> None:
        """Extend the newest frame to `timestamp`: the face has not moved since."""
        if self._frames and timestamp > self._frames[-1].timestamp:
            self.add(replace(self._frames[-1], timestamp=timestamp), now)

    def frame_at(self, now: float) -> PlayoutFrame | None:
        """Return the motion to draw at `now`, or None before the first frame is due."""
        self._drop_frames_of_an_old_clock()
        if not self._frames:
            return None
        self.playhead = max(self.playhead, self.clock.motion_playhead(now))
        while len(self._frames) > 1 and self._frames[1].timestamp < self.playhead - KEPT_S:
            self._frames.pop(0)
        at = bisect_right(self._frames, self.playhead, key=lambda f: f.timestamp)
        if at == 0:
            return None
        if at < len(self._frames):
            playout = PlayoutFrame(_interpolate(self._frames[at - 1], self._frames[at], self.playhead), 0.0, 0.0)
        else:
            playout = _extrapolate(self._frames[-1], self.playhead - self._frames[-1].timestamp)
        furrow = eased_furrow(self._frames[:at], self.playhead) * (1 - playout.neutral_blend)
        return replace(playout, frame=replace(playout.frame, furrow=furrow))

    def _drop_frames_of_an_old_clock(self) -> None:
        if self._restarts != self.clock.restarts:
            self._restarts = self.clock.restarts
            self._frames.clear()
            self.playhead = -np.inf


def _interpolate(a: MotionFrame, b: MotionFrame, timestamp: float) -> MotionFrame:
    begin = max(a.timestamp, b.timestamp - MAX_INTERPOLATION_S)
    weight = max(timestamp - begin, 0.0) / (b.timestamp - begin)
    return MotionFrame(
        timestamp,
        a.displacements + np.float32(weight) * (b.displacements - a.displacements),
        a.pose + weight * (b.pose - a.pose),
    )


def _extrapolate(newest: MotionFrame, age_s: float) -> PlayoutFrame:
    """Hold the newest frame, then fade its displacements to neutral with a smoothstep."""
    progress = float(np.clip((age_s - HOLD_S) / FADE_S, 0.0, 1.0))
    blend = progress * progress * (3 - 2 * progress)
    displacements = newest.displacements * np.float32(1 - blend)
    return PlayoutFrame(replace(newest, timestamp=newest.timestamp + age_s, displacements=displacements), age_s, blend)


def eased_furrow(frames: Sequence[MotionFrame], playhead: float, /) -> float:
    """Return the mean of the furrows over the EASE_S before the playhead. frames : up to the playhead, at least one"""
    begin, end, total = playhead - EASE_S, playhead, 0.0
    for frame in reversed(frames):
        since = max(frame.timestamp, begin)
        total += frame.furrow * (end - since)
        end = since
        if since == begin:
            break
    return (total + frames[0].furrow * (end - begin)) / EASE_S
