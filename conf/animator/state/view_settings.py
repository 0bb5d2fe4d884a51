"""How the face is shown: style, light, background, and whether it looks at who looks at it."""

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from conf.face.animation.gaze import EYE_RADIUS, LID_GAZE_COUPLING, gaze_angles
from conf.face.control_points import CONTROL_POINT_INDEX, PUPILS
from conf.face.head_pose import HeadPose
from conf.render.camera import ViewState, view_rotation

STYLES = ("rendered", "wireframe", "regions")
EYE_CONTACT_FADE = (0.45, 0.75)  # radians: up to the first eyes follow wholly, from the second on they look ahead


@dataclass(frozen=True)
class ViewSettings:
    """What the panel of the view says.

    influence : control point whose influence alone is coloured, None for all
    """

    view: ViewState = field(default_factory=lambda: ViewState(stats=False))
    style: str = "rendered"
    influence: int | None = None
    lights: str = "studio"
    background: str = "wall"
    eye_contact: bool = False


def with_eye_contact(displacements: NDArray[np.float32], pose: HeadPose, view: ViewState, /) -> NDArray[np.float32]:
    """Return the (n, 3) displacements, FAPU units, with the eyes turned to the viewer, wherever the head is turned."""
    x, y, z = view_rotation(pose, view)[2]  # the direction to the viewer in face axes
    yaw, pitch = math.atan2(x, z), math.asin(min(max(y, -1.0), 1.0))
    full, none = EYE_CONTACT_FADE
    share = min(max((none - max(abs(yaw), abs(pitch))) / (none - full), 0.0), 1.0)
    before = gaze_angles(displacements)
    wanted = share * np.array([yaw, pitch])
    changed = displacements.copy()
    changed[PUPILS, :2] = EYE_RADIUS * np.sin(wanted)
    for lid, follows in LID_GAZE_COUPLING.items():
        for eye, side in enumerate("lr"):
            changed[CONTROL_POINT_INDEX[f"{lid}_{side}"], 1] += follows * (wanted[1] - before[eye, 1])
    return changed
