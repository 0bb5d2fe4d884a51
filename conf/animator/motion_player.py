"""The player of recorded motion: one DPC file, its clock, and where the head is in it."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from conf.errors import ConfError
from conf.face.animation.playback import PlaybackClock, displacements_at, duration_of, pose_at
from conf.face.control_points import CONTROL_POINT_COUNT
from conf.face.fapu import Fapu
from conf.face.formats.dpc import MotionClip, read_dpc
from conf.face.head_pose import HeadPose
from conf.render.auto_framing import CENTRE, LOG_SCALE

REST_POSE = HeadPose(np.zeros(3), CENTRE, LOG_SCALE)


@dataclass(frozen=True)
class NamedClip:
    """A motion that can be played: fifty points, in FAPU units, the head's place taken to the picture's centre."""

    name: str
    motion: MotionClip

    @property
    def duration(self) -> float:
        """Seconds from the first frame to the last."""
        return duration_of(self.motion)

    def at(self, position: float) -> tuple[NDArray[np.float32], HeadPose]:
        """Return (n, 3) displacements, FAPU units, and the head's pose, at seconds from the beginning."""
        vector = pose_at(self.motion, position)
        pose = REST_POSE if vector is None else HeadPose.from_vector(vector)
        return displacements_at(self.motion, position), pose


def load_motion_clip(path: Path, fapu: Fapu, /) -> NamedClip:
    """Read a DPC file. fapu : of the face, for files in mesh units.

    Raises FileFormatError if it is not one, ConfError if its points are not ours.
    """
    motion = read_dpc(path)
    points = motion.displacements.shape[1]
    if points != CONTROL_POINT_COUNT:
        raise ConfError(f"{path} moves {points} control points: only motions of {CONTROL_POINT_COUNT} can be played")
    if motion.units != "fapu":
        in_units = (motion.displacements / fapu.lengths()).astype(np.float32)
        motion = replace(motion, displacements=in_units, units="fapu")
    return NamedClip(path.name, recentre(motion))


def recentre(motion: MotionClip, /) -> MotionClip:
    """Return the motion with its head's mean place and size those of the picture's centre."""
    if motion.poses is None:
        return motion
    poses = motion.poses.copy()
    mean = poses.mean(axis=0)
    poses[:, 3:5] = CENTRE + np.exp(LOG_SCALE - mean[5]) * (poses[:, 3:5] - mean[3:5])
    poses[:, 5] += LOG_SCALE - mean[5]
    return replace(motion, poses=poses)


class MotionPlayer:
    """A recording and the clock it plays by."""

    def __init__(self, recording: NamedClip, *, loop: bool = True) -> None:
        self.recording = recording
        self.clock = PlaybackClock(recording.duration, loop=loop)

    def toggle(self, now: float) -> None:
        """Pause if it plays, go on if it does not."""
        if self.clock.is_playing(now):
            self.clock.pause(now)
        else:
            self.clock.resume(now)

    def step(self, frames: int, now: float) -> None:
        """Stand still so many frames on."""
        self.clock.step(frames, self.recording.motion.fps, now)

    def frame(self, now: float) -> int:
        """Return the number of the frame that is shown, from 0."""
        return int(self.clock.position(now) * self.recording.motion.fps + 1e-6)

    def at(self, now: float) -> tuple[NDArray[np.float32], HeadPose]:
        """Return (n, 3) displacements, FAPU units, and the head's pose."""
        return self.recording.at(self.clock.position(now))
