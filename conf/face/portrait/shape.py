"""What must be known about a photographed face to move it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from conf.face.head_pose import HeadPose


@dataclass(frozen=True)
class FaceShape:
    """The photographed face, and the neutral pose that motion is told against.

    aspect : width of the picture over its height
    pose : of the head in the photograph
    points : (D, 3) float64 cm in face axes, head pose removed: control points, then outlines, as contours.ALL
    neutral : (n, 3) float64 cm in face axes: the control points of the person's neutral pose
    unit : (n, 3) float64 cm, the length of one FAPU unit for each axis of each control point
    outline : (K, 2) of the person, picture heights, x right, y up; fewer than three: everything is person
    """

    aspect: float
    pose: HeadPose
    points: NDArray[np.float64]
    neutral: NDArray[np.float64]
    unit: NDArray[np.float64]
    outline: NDArray[np.float64]


def project(points: NDArray[np.float64], pose: HeadPose, /) -> NDArray[np.float64]:
    """Return where points (k, 3) cm in face axes fall in the picture: (k, 2) picture heights, x right, y up."""
    turned = points @ pose.matrix()[:2].T
    return np.asarray(turned * np.exp(pose.log_scale) + pose.position)
