"""What moves the face at one moment: recording, emotions, action units and idle life laid over each other."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from conf.animator.motion_player import REST_POSE, MotionPlayer
from conf.animator.state.expression import ExpressionState
from conf.animator.state.view_settings import ViewSettings, with_eye_contact
from conf.face.animation.idle_motion import IdleMotion
from conf.face.animation.timed_expression import add_motions, blend_without_doubling
from conf.face.head_pose import HeadPose


@dataclass(frozen=True)
class MotionSample:
    """The motion at one moment: (n, 3) displacements in FAPU units, and the head's pose."""

    displacements: NDArray[np.float32]
    pose: HeadPose


def mix_motion(
    player: MotionPlayer | None, expressing: ExpressionState, idle: IdleMotion, look: ViewSettings, now: float, /
) -> MotionSample:
    """Return what the face does at a time in seconds."""
    displacements, pose = expressing.at(now), REST_POSE
    if player is not None:
        recorded, pose = player.at(now)
        displacements = blend_without_doubling(recorded, displacements)
    elif expressing.idle:
        life = idle.at(now)
        displacements = add_motions(displacements, life.displacements)
        pose = HeadPose.from_vector(pose.to_vector() + life.pose)
    if look.eye_contact:
        displacements = with_eye_contact(displacements, pose, look.view)
    return MotionSample(displacements, pose)
