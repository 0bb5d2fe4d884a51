"""Make and convert motion clips for export."""

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from conf.animator.motion_player import REST_POSE
from conf.face.animation.idle_motion import IdleMotion
from conf.face.animation.playback import displacements_at, duration_of, pose_at
from conf.face.animation.timed_expression import Envelope, TimedExpression, add_motions
from conf.face.formats.dpc import MotionClip

LEAD_SECONDS = 0.3  # neutral face before an expression starts and after it has ended
MIN_ASPECT = 0.8  # width over height of an image in which the head at rest fits


def make_expression_clip(
    displacements: NDArray[np.float32], envelope: Envelope, /, *, fps: float, idle: IdleMotion | None = None
) -> MotionClip:
    """Return a clip of an expression, (n, 3) FAPU units, that starts and ends with the neutral face.

    idle : motion added to it
    Raises ValueError if the envelope never ends.
    """
    if not math.isfinite(envelope.duration):
        raise ValueError("envelope must end")
    expression = TimedExpression(displacements, LEAD_SECONDS, envelope)
    frames, poses = [], []
    for i in range(max(2, math.ceil((envelope.duration + 2 * LEAD_SECONDS) * fps) + 1)):
        now = i / fps
        frame, pose = expression.at(now), REST_POSE.to_vector()
        if idle is not None:
            idle_sample = idle.at(now)
            frame, pose = add_motions(frame, idle_sample.displacements), pose + idle_sample.pose
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
