"""What must be known about a photographed face to move it."""

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from conf.face.fapu import Fapu
from conf.face.head_pose import HeadPose


@dataclass(frozen=True)
class PhotographedFace:
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
    fapu_lengths: NDArray[np.float64]
    outline: NDArray[np.float64]

    @classmethod
    def from_photo(
        cls,
        size: tuple[int, int],
        pose: NDArray[np.float64],
        points: NDArray[np.float64],
        neutral: NDArray[np.float64],
        fapu: tuple[float, ...],
        outline: NDArray[np.float64],
    ) -> Self:
        """Return the shape of what travels with a photograph.

        size : its width and height in px; pose : (6,), as HeadPose; points, neutral : cm, as here
        fapu : five distances of the neutral pose, cm; outline : (K, 2) 0 to 1 from the upper left corner
        """
        aspect = size[0] / size[1]
        unit = Fapu(*fapu).lengths()
        return cls(aspect, HeadPose.from_vector(pose), points, neutral, unit, (outline - 0.5) * (aspect, -1.0))


def project(points: NDArray[np.float64], pose: HeadPose, /) -> NDArray[np.float64]:
    """Return where points (k, 3) cm in face axes fall in the picture: (k, 2) picture heights, x right, y up."""
    turned = points @ pose.matrix()[:2].T
    return np.asarray(turned * np.exp(pose.log_scale) + pose.position)
