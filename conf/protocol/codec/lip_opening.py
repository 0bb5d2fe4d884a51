"""Keep the decoded opening of the mouth near the one sent: shut lips stay shut, and open lips stay open.

Strategy. The opening is a difference of two points, a small part of the error that the encoder keeps low. A millimetre
between lips that touch opens a shut mouth, and one less hides a short vowel. So the encoder decodes what it is about to
send, as a receiver without losses will. Where the opening is too far off, which is rare, it codes the frame
again with its target moved by the error, along the direction in which the opening changes the components least. The
payload only grows by what the nearer values cost, and decoders need no rule.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from conf.protocol.codec.reconstruction import HISTORY
from conf.protocol.codec.reference_frames import POSE_VALUES, QuantisedFrame
from conf.protocol.codec.transform import MotionTransform
from conf.protocol.messages import MotionFrame

# Eye distances; 0.0115 is 1 mm. A head draws an opening of up to 0.9 mm as none, and one of 1.75 mm as 1 mm.
MAX_ERROR = 0.0115
MAX_ERROR_STEPS = 1.25  # at least: coarser profiles would correct every second frame
NEARLY_SHUT = 0.0125  # openings below this are shown ...
MAX_SHOWN_SHUT = 0.0165  # ... at most this far open


@dataclass(frozen=True)
class LipOpening:
    """The opening of the mouth as a linear function of displacements.

    gradient : (3 n,) eye distances per FAPU unit
    by_component : (K,) eye distances per step
    max_error : eye distances: a larger error is corrected
    direction : (3 n,) FAPU units per eye distance: opens the mouth with the smallest change of the components
    """

    gradient: NDArray[np.float64]
    by_component: NDArray[np.float64]
    max_error: float
    direction: NDArray[np.float64]

    @classmethod
    def build(cls, gradient: NDArray[np.float64], transform: MotionTransform, /, *, step: float) -> "LipOpening":
        """Return the opening with its direction in the learned space. step : of the profile, eye distances"""
        by_component = transform.inverse_matrix @ gradient
        direction = by_component / (by_component @ by_component) @ transform.inverse_matrix
        return cls(gradient, by_component, max(MAX_ERROR, MAX_ERROR_STEPS * step), direction)

    def errors(
        self,
        transform: MotionTransform,
        frames: Sequence[MotionFrame],
        coded: Sequence[QuantisedFrame],
        earlier: Sequence[QuantisedFrame],
        /,
    ) -> list[float]:
        """Return by how much each frame is shown too far open, eye distances; 0 if that is little enough.

        coded : the frames as they would be sent; earlier : those one, two, ... strides before the first
        """
        known, errors = list(earlier), []
        for frame, quantised in zip(frames, coded, strict=True):
            sent = float(frame.displacements.reshape(-1) @ self.gradient)
            received = float(transform.shown_values(quantised, known)[POSE_VALUES:] @ self.by_component)
            for point, steps in quantised.residuals.items():
                received += float(self.gradient[3 * point : 3 * point + 3] @ (transform.residual_steps[point] * steps))
            opens = sent < NEARLY_SHUT and received > MAX_SHOWN_SHUT
            errors.append(received - sent if opens or abs(received - sent) > self.max_error else 0.0)
            known = [quantised, *known[: HISTORY - 1]]
        return errors

    def correct(self, frames: Sequence[MotionFrame], errors: Sequence[float], /) -> list[MotionFrame]:
        """Return targets whose mouths are less open by the errors."""
        shifts = [(error * self.direction).reshape(-1, 3).astype(np.float32) for error in errors]
        return [
            replace(frame, displacements=frame.displacements - shift)
            for frame, shift in zip(frames, shifts, strict=True)
        ]
