"""Motion to be exported: an emotion as it comes and goes, a recording at another rate."""

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from conf.animator.motion_player import REST_POSE
from conf.face.animation.idle_motion import IdleMotion
from conf.face.animation.playback import displacements_at, duration_of, pose_at
from conf.face.animation.timed_expression import Envelope, TimedExpression, add_motions
from conf.face.formats.dpc import MotionClip

LEAD_SECONDS = 0.3  # before an emotion begins and after it has gone


def make_expression_clip(
    displacements: NDArray[np.float32],
    envelope: Envelope,
    /,
    *,
    fps: float,
    idle: IdleMotion | None = None,
) -> MotionClip:
    """Return an emotion, (n, 3) FAPU units, from the neutral face and back to it.

    idle : what the face does beside it; None holds it still
    Raises ValueError if the envelope never ends.
    """
    if not math.isfinite(envelope.duration):
        raise ValueError("envelope must end")
    seconds = envelope.duration + 2 * LEAD_SECONDS
    performance = TimedExpression(displacements, LEAD_SECONDS, envelope)
    frames, poses = [], []
    for i in range(max(2, math.ceil(seconds * fps) + 1)):
        now = i / fps
        frame, pose = performance.at(now), REST_POSE.to_vector()
        if idle is not None:
            life = idle.at(now)
            frame, pose = add_motions(frame, life.displacements), pose + life.pose
        frames.append(frame)
        poses.append(pose)
    return MotionClip(fps, "fapu", np.array(frames, np.float32), np.array(poses))


def peak_time(envelope: Envelope, /) -> float:
    """Return the seconds at which an `emotion_motion` is strongest."""
    return LEAD_SECONDS + envelope.onset + min(envelope.hold, 1.0) / 2


def resample(motion: MotionClip, fps: float, /) -> MotionClip:
    """Return the same motion with another number of frames a second."""
    if fps == motion.fps:
        return motion
    times = [i / fps for i in range(int(duration_of(motion) * fps + 1e-6) + 1)]
    displacements = np.array([displacements_at(motion, time) for time in times], np.float32)
    poses = None if motion.poses is None else np.array([pose_at(motion, time) for time in times])
    return replace(motion, fps=fps, displacements=displacements, poses=poses)


def fit_to_aspect(motion: MotionClip, size: tuple[int, int], /) -> MotionClip:
    """Return the motion with the head drawn smaller where a picture of (W, H) pixels is too narrow for it."""
    shrink = min(1.0, size[0] / size[1] / 0.8)
    if motion.poses is None or shrink == 1.0:
        return motion
    poses = motion.poses.copy()
    poses[:, 3:5] *= shrink
    poses[:, 5] += math.log(shrink)
    return replace(motion, poses=poses)
