"""Motion clips of the animator: reading, sampling, conversion for export, and the player of one clip."""

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from conf.errors import ConfError
from conf.face.animation.idle_motion import IdleMotion
from conf.face.animation.playback import PlaybackClock, displacements_at, duration_of, pose_at
from conf.face.animation.timed_expression import Envelope, TimedExpression, add_motions
from conf.face.control_points import CONTROL_POINT_COUNT
from conf.face.fapu import Fapu
from conf.face.formats.dpc import MotionClip, read_dpc
from conf.face.head_pose import HeadPose
from conf.render.auto_framing import CENTRE, LOG_SCALE

REST_POSE = HeadPose(np.zeros(3), CENTRE, LOG_SCALE)


@dataclass(frozen=True)
class MotionSample:
    """Motion at one time: (n, 3) displacements in FAPU units, and the head pose."""

    displacements: NDArray[np.float32]
    pose: HeadPose


def sample_clip(clip: MotionClip, position: float, /) -> MotionSample:
    """Interpolate a clip in FAPU units at seconds from its start; without poses the head is at rest."""
    vector = pose_at(clip, position)
    return MotionSample(displacements_at(clip, position), REST_POSE if vector is None else HeadPose.from_vector(vector))


def load_motion_clip(path: Path, fapu: Fapu, /) -> MotionClip:
    """Read a DPC file as a clip in FAPU units with the head's mean position in the centre of the image.

    fapu : of the face, to convert files in mesh units
    Raises FileFormatError if it is no DPC file, ConfError if it has another number of control points.
    """
    clip = read_dpc(path)
    points = clip.displacements.shape[1]
    if points != CONTROL_POINT_COUNT:
        raise ConfError(f"{path} moves {points} control points: only motions of {CONTROL_POINT_COUNT} can be played")
    if clip.units != "fapu":
        in_fapu = (clip.displacements / fapu.lengths()).astype(np.float32)
        clip = replace(clip, displacements=in_fapu, units="fapu")
    return recentre(clip)


def recentre(clip: MotionClip, /) -> MotionClip:
    """Return the clip with the head's mean position and scale set to those of the rest pose."""
    if clip.poses is None:
        return clip
    poses = clip.poses.copy()
    mean = poses.mean(axis=0)
    poses[:, 3:5] = CENTRE + np.exp(LOG_SCALE - mean[5]) * (poses[:, 3:5] - mean[3:5])
    poses[:, 5] += LOG_SCALE - mean[5]
    return replace(clip, poses=poses)


class MotionPlayer(PlaybackClock):
    """The playback clock of a clip."""

    def __init__(self, name: str, clip: MotionClip, *, loop: bool = True) -> None:
        super().__init__(duration_of(clip), loop=loop)
        self.name = name
        self.clip = clip

    def toggle(self, now: float) -> None:
        """Pause or resume."""
        if self.is_playing(now):
            self.pause(now)
        else:
            self.resume(now)

    def frame(self, now: float) -> int:
        """Return the index of the current frame."""
        return int(self.position(now) * self.clip.fps + 1e-6)

    def at(self, now: float) -> MotionSample:
        """Return the motion at a time in seconds."""
        return sample_clip(self.clip, self.position(now))


IDLE_SEED = 2007  # of the idle motion of a clip, so that the same export writes the same file
LEAD_SECONDS = 0.3  # neutral face before an expression starts and after it has ended
MIN_ASPECT = 0.8  # width over height of an image in which the head at rest fits


def make_expression_clip(
    expressions: Iterable[NDArray[np.float32]], envelope: Envelope, /, *, fps: float, idle: bool
) -> MotionClip:
    """Return a clip of expressions, each (n, 3) FAPU units, that starts and ends with the neutral face.

    idle : whether idle motion is added, the same in every clip
    Raises ValueError if the envelope never ends.
    """
    if not math.isfinite(envelope.duration):
        raise ValueError("envelope must end")
    idle_motion = IdleMotion(np.random.default_rng(IDLE_SEED))
    times = np.arange(max(2, math.ceil((envelope.duration + 2 * LEAD_SECONDS) * fps) + 1)) / fps
    frames, poses = [], []
    for displacements in expressions:
        expression = TimedExpression(displacements, LEAD_SECONDS, envelope)
        for now in times.tolist():
            frame, pose = expression.at(now), REST_POSE.to_vector()
            if idle:
                idle_displacements, idle_pose = idle_motion.at(now)
                frame, pose = add_motions(frame, idle_displacements), pose + idle_pose
            frames.append(frame)
            poses.append(pose)
    return MotionClip(fps, "fapu", np.array(frames, np.float32), np.array(poses))


def peak_time(envelope: Envelope, /) -> float:
    """Return the seconds from the start of an expression's clip to its peak."""
    return LEAD_SECONDS + envelope.onset + min(envelope.hold, 1.0) / 2


def resample(clip: MotionClip, fps: float, /) -> MotionClip:
    """Return the clip at another frame rate."""
    if fps == clip.fps:
        return clip
    times = [i / fps for i in range(int(duration_of(clip) * fps + 1e-6) + 1)]
    displacements = np.array([displacements_at(clip, time) for time in times], np.float32)
    poses = None if clip.poses is None else np.array([pose_at(clip, time) for time in times])
    return replace(clip, fps=fps, displacements=displacements, poses=poses)


def fit_to_aspect(clip: MotionClip, size: tuple[int, int], /) -> MotionClip:
    """Return the clip with a smaller head if an image of (W, H) pixels is too narrow for it."""
    scale = min(1.0, size[0] / size[1] / MIN_ASPECT)
    if scale == 1.0:
        return clip
    poses = np.tile(REST_POSE.to_vector(), (len(clip.displacements), 1)) if clip.poses is None else clip.poses.copy()
    poses[:, 3:5] *= scale
    poses[:, 5] += math.log(scale)
    return replace(clip, poses=poses)
