"""The head pose: rotation, position and scale of the head in the frame, independent of the expression.

The camera is scaled orthographic, as are the tracker's landmarks: x to the frame's right, y up, z to the viewer.
Without rotation, face axes and frame axes coincide: the subject's left on +x, the crown on +y, the nose on +z.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from conf.face.rotations import rotation_matrix, yaw_pitch_roll

ES0_CM = 6.4  # distance between the pupils of a face in model centimetres, the unit of `log_scale`


@dataclass(frozen=True)
class HeadPose:
    """Rotation, position and scale of a head.

    rotation : (3,) float64, rotation vector in radians, from face axes to frame axes
    position : (2,) float64, the face's origin in frame heights from the centre, x right, y up
    log_scale : natural logarithm of the length of one model centimetre in frame heights
    """

    rotation: NDArray[np.float64]
    position: NDArray[np.float64]
    log_scale: float

    @classmethod
    def from_vector(cls, vector: NDArray[np.floating], /) -> "HeadPose":
        """Return the pose of a (6,) vector: rotation, position, log scale."""
        values = np.asarray(vector, dtype=np.float64)
        return cls(values[:3], values[3:5], float(values[5]))

    def to_vector(self) -> NDArray[np.float64]:
        """Return the (6,) vector as transmitted: rotation, position, log scale."""
        return np.concatenate([self.rotation, self.position, [self.log_scale]])

    def matrix(self) -> NDArray[np.float64]:
        """Return the (3, 3) rotation matrix from face axes to frame axes."""
        return rotation_matrix(self.rotation)

    def yaw_pitch_roll(self) -> tuple[float, float, float]:
        """Return angles in degrees: yaw to the subject's left, pitch up, roll of the crown to the subject's right."""
        yaw, pitch, roll = map(math.degrees, yaw_pitch_roll(self.matrix()))
        return yaw, -pitch, roll


NEUTRAL_POSE = HeadPose(np.zeros(3), np.zeros(2), float(np.log(0.25 / ES0_CM)))
