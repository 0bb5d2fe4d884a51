"""Motion to be exported: an emotion as it comes and goes, a recording at another rate."""

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from conf.animator.motion_player import REST_POSE
from conf.face.animation.idle_motion import IdleMotion
from conf.face.animation.playback import displacements_at, duration_of, pose_at
from conf.face.animation.timed_expression import Envelope, Performance, lay_over
from conf.face.formats.dpc import Motion

QUIET_SECONDS = 0.3  # before an emotion begins and after it has gone


def emotion_motion(
    displacements: NDArray[np.float32],
    envelope: Envelope,
    /,
    *,
    fps: float,
    idle: IdleMotion | None = None,
) -> Motion:
    """Return an emotion, (n, 3) FAPU units, from the neutral face and back to it.

    idle : what the face does beside it; None holds it still
    Raises ValueError if the envelope never ends.
    """
    if not math.isfinite(envelope.duration):
        raise ValueError("envelope must end")
    seconds = envelope.duration + 2 * QUIET_SECONDS
    performance = Performance(displacements, QUIET_SECONDS, envelope)
    frames, poses = [], []
    for i in range(max(2, math.ceil(seconds * fps) + 1)):
        now = i / fps
        frame, pose = performance.at(now), REST_POSE.to_vector()
        if idle is not None:
            life = idle.at(now)
            frame, pose = lay_over(frame, life.displacements), pose + life.pose
        frames.append(frame)
        poses.append(pose)
    return Motion(fps, "fapu", np.array(frames, np.float32), np.array(poses))


def peak(envelope: Envelope, /) -> float:
    """Return the seconds at which an `emotion_motion` is strongest."""
    return QUIET_SECONDS + envelope.onset + min(envelope.hold, 1.0) / 2


def resampled(motion: Motion, fps: float, /) -> Motion:
    """Return the same motion with another number of frames a second."""
    if fps == motion.fps:
        return motion
    times = [i / fps for i in range(int(duration_of(motion) * fps + 1e-6) + 1)]
    displacements = np.array([displacements_at(motion, time) for time in times], np.float32)
    poses = None if motion.poses is None else np.array([pose_at(motion, time) for time in times])
    return replace(motion, fps=fps, displacements=displacements, poses=poses)


def stretch(motion: Motion, size: tuple[int, int], /) -> Motion:
    """Return the motion with the head drawn smaller where a picture of (W, H) pixels is too narrow for it."""
    shrink = min(1.0, size[0] / size[1] / 0.8)
    if motion.poses is None or shrink == 1.0:
        return motion
    poses = motion.poses.copy()
    poses[:, 3:5] *= shrink
    poses[:, 5] += math.log(shrink)
    return replace(motion, poses=poses)
