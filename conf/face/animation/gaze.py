"""Gaze as displacements of the two pupils.

The tracker measures positions of pupils, not angles. Rotating an eye moves its pupil by radius times sine.
"""

import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_COUNT, CONTROL_POINT_INDEX, PUPILS
from conf.face.fapu import UNITS_PER_DISTANCE

EYE_RADIUS = 12 / 64 * UNITS_PER_DISTANCE  # FAPU units (ES0): a human eyeball's 12 mm, at 64 mm between the pupils
LID_GAZE_COUPLING = {"eyelid_upper": 1000.0, "eyelid_lower": 450.0}  # FAPU units (IRISD0) a radian of pitch


def gaze_displacements(yaw: float, pitch: float, /) -> NDArray[np.float32]:
    """Return the (n, 3) displacements, FAPU units, of rotated eyes and of the lids that follow them.

    yaw : radians to the subject's left
    pitch : radians up
    """
    displacements = np.zeros((CONTROL_POINT_COUNT, 3), np.float32)
    displacements[PUPILS, :2] = EYE_RADIUS * np.sin([yaw, pitch])
    for lid, coupling in LID_GAZE_COUPLING.items():
        displacements[[CONTROL_POINT_INDEX[f"{lid}_l"], CONTROL_POINT_INDEX[f"{lid}_r"]], 1] = coupling * pitch
    return displacements


def gaze_angles(displacements: NDArray[np.floating], /) -> NDArray[np.float64]:
    """Return (..., 2 eyes left and right, 2) radians, yaw to the subject's left and pitch up, of (..., n, 3) FAPU."""
    sines = np.clip(np.asarray(displacements, np.float64)[..., PUPILS, :2] / EYE_RADIUS, -1.0, 1.0)
    return np.asarray(np.arcsin(sines))
