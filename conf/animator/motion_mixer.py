"""Mix the motion of a recording, expressions, action units and idle motion; turn the eyes to the viewer."""

import math
from dataclasses import replace

import numpy as np

from conf.animator.motion_player import REST_POSE, MotionPlayer, MotionSample
from conf.animator.state.editor import ViewSettings
from conf.face.animation.expression_state import ExpressionState
from conf.face.animation.gaze import EYE_RADIUS, LID_GAZE_COUPLING, gaze_angles
from conf.face.animation.idle_motion import IdleMotion
from conf.face.animation.timed_expression import add_motions, blend_without_doubling
from conf.face.control_points import CONTROL_POINT_INDEX, PUPILS
from conf.face.head_pose import HeadPose
from conf.render.camera import ViewState, view_rotation

EYE_CONTACT_FADE = (0.45, 0.75)  # rad between face and viewer: full eye contact below the first, none above the second


def mix_motion(
    player: MotionPlayer | None, expression: ExpressionState, idle: IdleMotion, view: ViewSettings, now: float, /
) -> MotionSample:
    """Return the motion at a time in seconds. Idle motion is added only if no recording is open."""
    displacements, pose = expression.at(now), REST_POSE
    if player is not None:
        recorded = player.at(now)
        displacements, pose = blend_without_doubling(recorded.displacements, displacements), recorded.pose
    elif expression.idle:
        idle_displacements, idle_pose = idle.at(now)
        displacements = add_motions(displacements, idle_displacements)
        pose = HeadPose.from_vector(pose.to_vector() + idle_pose)
    sample = MotionSample(displacements, pose)
    return with_eye_contact(sample, view.camera) if view.eye_contact else sample


def with_eye_contact(sample: MotionSample, camera: ViewState, /) -> MotionSample:
    """Return the motion with the eyes turned to the viewer, and the eyelids following them."""
    x, y, z = view_rotation(sample.pose, camera)[2]  # direction to the viewer in face axes
    yaw, pitch = math.atan2(x, z), math.asin(min(max(y, -1.0), 1.0))
    full, none = EYE_CONTACT_FADE
    weight = min(max((none - max(abs(yaw), abs(pitch))) / (none - full), 0.0), 1.0)
    before = gaze_angles(sample.displacements)
    angles = weight * np.array([yaw, pitch])
    displacements = sample.displacements.copy()
    displacements[PUPILS, :2] = EYE_RADIUS * np.sin(angles)
    for lid, coupling in LID_GAZE_COUPLING.items():
        for eye, side in enumerate("lr"):
            displacements[CONTROL_POINT_INDEX[f"{lid}_{side}"], 1] += coupling * (angles[1] - before[eye, 1])
    return replace(sample, displacements=displacements)
