"""From motion to numbers of equal worth and back: the float part of the codec, which steers no bit of it.

Strategy. Every number that is quantised should do the same harm when it is off by one step. Displacements are weighted
so that their squared sum is the mean squared error that a viewer sees in the picture (in eye distances; depth, which a
face seen from the front hides, counts less; some points count more), and turned into the principal directions of the
weighted space. Pose is taken about the *middle* of the face, measured in face sizes: then a small rotation, a move and
a growth of the head disturb each other least, and one step of each moves the points equally far. The size comes first,
because the middle is measured in it, and what rounding the pose has moved, the components partly move back.

Rounding throws away where in its step a value was. Two things bring some of it back without a bit. In every second
payload that is predicted from nothing, the values that are hardly ever still count from half a step further
(*staggered*): two frames in a row then tell more than either. And a value that was one step away in the frame before
has most likely just crossed the border: it *leans* that way. A receiver that missed the frame before shows the plain
value, so nothing is lost but the gain.
Source: Martin, Cohen 1986 and Gray, Stockham 1993 (dither); Vaishampayan 1993 (staggered quantisers).
"""

from dataclasses import dataclass
from math import cos, exp, hypot, sin

import numpy as np
from numpy.typing import NDArray

from conf.protocol.codec.quantised_frame import FACE_CENTRE, LOG_SCALE, POSE_VALUES, ROTATION, QuantisedFrame


@dataclass(frozen=True)
class MotionTransform:
    """The trained linear maps, for one step.

    forward_matrix : (3 n, K) float64, displacements to components, in steps
    inverse_matrix : (K, 3 n) float64, and back
    pose_steps : (6,) float64, one step of log scale, rotation (3) and middle (2, in model centimetres)
    middle : (3,) float64, the middle of the points of a typical neutral face, model centimetres
    usual_log_scale : log scale of a typical frame
    correction_steps : (n, 3) float64, one step of a correction, FAPU units
    coupling : (6, K) float64, steps of each component that look most like one step of the pose
    stagger : (6 + K,) float64, steps that the values of a staggered frame count from
    lean : (6 + K,) float64, how much of the way to the frame before a value goes that is at most a step away
    """

    forward_matrix: NDArray[np.float64]
    inverse_matrix: NDArray[np.float64]
    pose_steps: NDArray[np.float64]
    face_centre: NDArray[np.float64]
    typical_log_scale: float
    residual_steps: NDArray[np.float64]
    coupling: NDArray[np.float64]
    stagger: NDArray[np.float64]
    reconstruction_shift: NDArray[np.float64]

    def log_scale(self, pose: NDArray[np.float64], /) -> float:
        """Return a pose's log scale in steps from the usual."""
        return float((pose[5] - self.typical_log_scale) / self.pose_steps[LOG_SCALE])

    def forward(
        self, displacements: NDArray[np.float32], pose: NDArray[np.float64], /, *, log_scale: int
    ) -> NDArray[np.float64]:
        """Return the values (6 + K,) of a frame in steps, not yet rounded, given the log scale that will be sent.

        displacements : (n, 3) FAPU units; pose : (6,) as in conf.protocol.messages
        """
        size = exp(self.typical_log_scale + log_scale * self.pose_steps[LOG_SCALE])
        middle = pose[3:5] + exp(pose[5]) * self._turned_middle(pose[:3])
        return np.concatenate(
            [
                [log_scale],
                pose[:3] / self.pose_steps[ROTATION],
                middle / size / self.pose_steps[FACE_CENTRE],
                displacements.reshape(-1) @ self.forward_matrix,
            ]
        )

    def residual(self, displacements: NDArray[np.float32], /) -> NDArray[np.float64]:
        """Return what the components cannot carry of displacements (n, 3), in steps of a correction."""
        flat = displacements.reshape(-1)
        left = flat - flat @ self.forward_matrix @ self.inverse_matrix
        return np.asarray(left.reshape(-1, 3) / self.residual_steps)

    def compensate_pose_error(self, pose_error: NDArray[np.float64], /) -> NDArray[np.float64]:
        """Return what to add to the components (K,) so that they make up for a pose that is off by some steps (6,)."""
        return np.asarray(pose_error @ self.coupling)

    def dequantise(self, frame: QuantisedFrame, /) -> NDArray[np.float64]:
        """Return the values (6 + K,) of a frame in steps."""
        values = np.array(frame.values, dtype=np.float64)
        return values + self.stagger if frame.staggered else values

    def inverse(
        self, frame: QuantisedFrame, before: QuantisedFrame | None = None, /
    ) -> tuple[NDArray[np.float32], NDArray[np.float64]]:
        """Return displacements (n, 3) in FAPU units and pose (6,).

        before : the frame one tick earlier, if it is known
        """
        numbers = self.dequantise(frame)
        if before is not None:
            numbers += self._lean(self.dequantise(before) - numbers)
        displacements = (numbers[POSE_VALUES:] @ self.inverse_matrix).reshape(-1, 3)
        for point, steps in frame.residuals.items():
            displacements[point] += self.residual_steps[point] * steps
        scaled = numbers[:POSE_VALUES] * self.pose_steps
        log_scale = scaled[LOG_SCALE] + self.typical_log_scale
        rotation = scaled[ROTATION]
        position = exp(log_scale) * (scaled[FACE_CENTRE] - self._turned_middle(rotation))
        return displacements.astype(np.float32), np.array([*rotation, *position, log_scale])

    def _lean(self, way: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return how far (6 + K,) to move towards the frame before, which lies `way` steps off."""
        lean = np.where(np.abs(way) <= 1, self.reconstruction_shift * way, 0.0)
        lean[POSE_VALUES:] -= self.compensate_pose_error(
            lean[:POSE_VALUES]
        )  # the components made up for a pose that did not lean
        return lean

    def _turned_middle(self, rotation: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return x and y (2,) of the middle turned by a rotation vector. Source: Rodrigues' formula."""
        x, y, z = rotation.tolist()
        a, b, c = self.face_centre.tolist()
        angle = hypot(x, y, z)
        if angle < 1e-9:
            return self.face_centre[:2]
        sine, versine = sin(angle) / angle, (1 - cos(angle)) / angle**2
        along = (x * a + y * b + z * c) * versine
        return np.array(
            [
                a * cos(angle) + (y * c - z * b) * sine + x * along,
                b * cos(angle) + (z * a - x * c) * sine + y * along,
            ]
        )
