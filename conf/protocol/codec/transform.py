"""Motion to values of equal importance and back: the floating-point part of the codec, which steers no bit.

Strategy. One step of any quantised value should cause the same error. Displacements are weighted so that their squared
sum is the mean squared error in the image (in eye distances; depth, which a frontal view hides, counts less; some
points count more), and projected on the principal directions of the weighted space. The pose is expressed about the
*face centre*, in face sizes: then small rotations, translations and changes of size affect each other least, and one
step of each moves the points equally far. The size is coded first, because the face centre is measured in it. The
components partly compensate the motion that rounding the pose causes.

Rounding loses the position of a value inside its step. Two methods recover part of it at no cost in bits. In every
second payload without reference, the values that are rarely constant count from half a step further (*staggered*), so
that two consecutive frames give more information than one. And the position is estimated from the two frames before
(reconstruction.py); a receiver that missed them shows nearly the plain value.
Source: Gray, Stockham 1993 (dither); Vaishampayan 1993 (staggered quantisers).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import cos, exp, hypot, sin

import numpy as np
from numpy.typing import NDArray

from conf.protocol.codec.reconstruction import Reconstruction
from conf.protocol.codec.reference_frames import FACE_CENTRE, LOG_SCALE, POSE_VALUES, ROTATION, QuantisedFrame


@dataclass(frozen=True)
class MotionTransform:
    """The trained linear maps for one step size.

    forward_matrix : (3 n, K) float64, displacements to components, in steps
    inverse_matrix : (K, 3 n) float64, the inverse
    pose_steps : (6,) float64, one step of log scale, rotation (3, radians) and face centre (2, face sizes)
    face_centre : (3,) float64, mean of the points of a typical neutral face, model centimetres
    typical_log_scale : log scale of a typical frame
    residual_steps : (n, 3) float64, one step of a point residual, FAPU units
    coupling : (6, K) float64, steps of each component that resemble one step of the pose most
    stagger : (6 + K,) float64, offset of the values of a staggered frame, steps
    reconstruction : estimates the position of values inside their step
    """

    forward_matrix: NDArray[np.float64]
    inverse_matrix: NDArray[np.float64]
    pose_steps: NDArray[np.float64]
    face_centre: NDArray[np.float64]
    typical_log_scale: float
    residual_steps: NDArray[np.float64]
    coupling: NDArray[np.float64]
    stagger: NDArray[np.float64]
    reconstruction: Reconstruction

    def log_scale(self, pose: NDArray[np.float64], /) -> float:
        """Return a pose's log scale in steps from the typical one."""
        return float((pose[5] - self.typical_log_scale) / self.pose_steps[LOG_SCALE])

    def forward(
        self, displacements: NDArray[np.float32], pose: NDArray[np.float64], /, *, log_scale: int
    ) -> NDArray[np.float64]:
        """Return the values (6 + K,) of a frame in steps, not rounded.

        displacements : (n, 3) FAPU units; pose : (6,) as in MotionFrame; log_scale : the value that will be sent
        """
        size = exp(self.typical_log_scale + log_scale * self.pose_steps[LOG_SCALE])
        centre = pose[3:5] + exp(pose[5]) * self._rotated_centre(pose[:3])
        rotation, centre = pose[:3] / self.pose_steps[ROTATION], centre / size / self.pose_steps[FACE_CENTRE]
        return np.concatenate([[log_scale], rotation, centre, displacements.reshape(-1) @ self.forward_matrix])

    def residual(self, displacements: NDArray[np.float32], /) -> NDArray[np.float64]:
        """Return the part of displacements (n, 3) that the components cannot represent, in steps of a residual."""
        flat = displacements.reshape(-1)
        remainder = flat - flat @ self.forward_matrix @ self.inverse_matrix
        return np.asarray(remainder.reshape(-1, 3) / self.residual_steps)

    def compensate_pose_error(self, pose_error: NDArray[np.float64], /) -> NDArray[np.float64]:
        """Return what to add to the components (K,) to compensate a pose error (6,), in steps."""
        return np.asarray(pose_error @ self.coupling)

    def dequantise(self, frame: QuantisedFrame, /) -> NDArray[np.float64]:
        """Return the values (6 + K,) of a frame in steps."""
        values = np.array(frame.values, dtype=np.float64)
        return values + self.stagger if frame.staggered else values

    def shown_values(self, frame: QuantisedFrame, earlier: Sequence[QuantisedFrame] = (), /) -> NDArray[np.float64]:
        """Return the values (6 + K,) of a frame as `inverse` shows them, steps."""
        values = self.dequantise(frame)
        if earlier:
            shift = self.reconstruction.expected_error(values, [self.dequantise(before) for before in earlier])
            # The components were computed for a pose without shift.
            shift[POSE_VALUES:] -= self.compensate_pose_error(shift[:POSE_VALUES])
            values += shift
        return values

    def inverse(
        self, frame: QuantisedFrame, earlier: Sequence[QuantisedFrame] = (), /
    ) -> tuple[NDArray[np.float32], NDArray[np.float64]]:
        """Return displacements (n, 3) in FAPU units and pose (6,).

        earlier : the frames one and two strides earlier, as far as they are known without a gap
        """
        values = self.shown_values(frame, earlier)
        displacements = (values[POSE_VALUES:] @ self.inverse_matrix).reshape(-1, 3)
        for point, steps in frame.residuals.items():
            displacements[point] += self.residual_steps[point] * steps
        scaled = values[:POSE_VALUES] * self.pose_steps
        log_scale = scaled[LOG_SCALE] + self.typical_log_scale
        rotation = scaled[ROTATION]
        position = exp(log_scale) * (scaled[FACE_CENTRE] - self._rotated_centre(rotation))
        return displacements.astype(np.float32), np.array([*rotation, *position, log_scale])

    def _rotated_centre(self, rotation: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return x and y (2,) of the face centre rotated by a rotation vector. Source: Rodrigues' formula."""
        x, y, z = rotation.tolist()
        a, b, c = self.face_centre.tolist()
        angle = hypot(x, y, z)
        if angle < 1e-9:
            return self.face_centre[:2]
        sine, versine = sin(angle) / angle, (1 - cos(angle)) / angle**2
        along = (x * a + y * b + z * c) * versine
        return np.array(
            [a * cos(angle) + (y * c - z * b) * sine + x * along, b * cos(angle) + (z * a - x * c) * sine + y * along]
        )
