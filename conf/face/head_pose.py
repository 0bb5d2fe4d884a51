"""Where the head is: rotation, place in the picture and size, apart from the expression.

The camera is scaled orthographic, as the tracker's landmarks are: x to the picture's right, y up, z to the viewer.
A face that looks straight at the camera has its own left on +x, its crown on +y and its nose on +z, so a face without
rotation has the same axes as the picture.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

ES0_CM = 6.4  # eye distance of a model face in its own centimetres: what `log_scale` is relative to


@dataclass(frozen=True)
class HeadPose:
    """Six numbers that place a face in a picture.

    rotation : (3,) float64, rotation vector in radians, from face axes to picture axes
    position : (2,) float64, the face's origin in picture heights from the centre, x right, y up
    log_scale : natural logarithm of the length of one model centimetre in picture heights
    """

    rotation: NDArray[np.float64]
    position: NDArray[np.float64]
    log_scale: float

    @classmethod
    def from_vector(cls, vector: NDArray[np.floating], /) -> "HeadPose":
        """Read the (6,) vector that travels: rotation, position, log scale."""
        values = np.asarray(vector, dtype=np.float64)
        return cls(values[:3], values[3:5], float(values[5]))

    def to_vector(self) -> NDArray[np.float64]:
        """Return the (6,) vector that travels: rotation, position, log scale."""
        return np.concatenate([self.rotation, self.position, [self.log_scale]])

    def matrix(self) -> NDArray[np.float64]:
        """Return the (3, 3) rotation matrix from face axes to picture axes."""
        return Rotation.from_rotvec(self.rotation).as_matrix()

    def yaw_pitch_roll(self) -> tuple[float, float, float]:
        """Return degrees: yaw to the subject's left, pitch up, roll of the crown to the subject's right."""
        yaw, pitch, roll = Rotation.from_rotvec(self.rotation).as_euler("YXZ", degrees=True)
        return float(yaw), float(-pitch), float(roll)


NEUTRAL_POSE = HeadPose(np.zeros(3), np.zeros(2), float(np.log(0.25 / ES0_CM)))
