"""What must be known about a photographed face to move it."""

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from conf.face.fapu import Fapu
from conf.face.head_pose import HeadPose


@dataclass(frozen=True)
class PhotographedFace:
    """The photographed face, and the neutral pose that motion is relative to.

    aspect : width of the photo over its height
    pose : of the head in the photo
    points : (D, 3) float64 cm in face axes, head pose removed: control points, then outlines
    neutral : (n, 3) float64 cm in face axes: the control points of the person's neutral pose
    fapu_lengths : (n, 3) float64 cm, the length of one FAPU unit for each axis of each control point
    outline : (K, 2) of the person, image heights from the centre, y up; fewer than three: everything is person
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
        """Return the face of a received photo.

        size : its width and height in px; pose : (6,), as HeadPose; points, neutral : cm, as above
        fapu : five distances of the neutral pose, cm; outline : (K, 2) 0 to 1 from the upper left corner
        """
        aspect = size[0] / size[1]
        lengths = Fapu(*fapu).lengths()
        return cls(aspect, HeadPose.from_vector(pose), points, neutral, lengths, (outline - 0.5) * (aspect, -1.0))

    def upright(self, positions_cm: NDArray[np.float64], /) -> NDArray[np.float64]:
        """Return positions (V, 2) rotated in the image's plane such that the head's vertical axis points up."""
        axis = self.pose.matrix()[:2, 1]
        axis = axis / max(float(np.linalg.norm(axis)), 1e-6)
        return np.asarray(positions_cm @ np.array([[axis[1], axis[0]], [-axis[0], axis[1]]]))


def project(points: NDArray[np.float64], pose: HeadPose, /) -> NDArray[np.float64]:
    """Return the projection (k, 2) of points (k, 3), cm in face axes: image heights from the centre, y up."""
    return np.asarray(points @ pose.matrix()[:2].T * np.exp(pose.log_scale) + pose.position)
