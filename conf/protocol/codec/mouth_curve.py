"""Keep a length of the decoded mouth near the one sent: correct the frames in which rounding moved it too far.

Strategy. A length of the mouth is a difference of two points, a small part of the error that the encoder keeps low. So
the encoder decodes what it is about to send, as a receiver without losses will. Where the length is too far off, which
is rare, it codes the frame again with its target moved by the error, along the direction in which the length changes
the components least. The payload only grows by what the nearer values cost, and decoders need no rule.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from conf.protocol.codec.reconstruction import HISTORY
from conf.protocol.codec.reference_frames import POSE_VALUES, QuantisedFrame
from conf.protocol.codec.transform import MotionTransform
from conf.protocol.messages import MotionFrame


@dataclass(frozen=True)
class MouthCurve:
    """A length of the mouth as a linear function of displacements.

    gradient : (3 n,) eye distances per FAPU unit
    by_component : (K,) eye distances per step
    max_error : eye distances: a larger error is corrected
    direction : (3 n,) FAPU units per eye distance: changes the length with the smallest change of the components
    """

    gradient: NDArray[np.float64]
    by_component: NDArray[np.float64]
    max_error: float
    direction: NDArray[np.float64]

    def is_too_far(self, sent: float, received: float, /) -> bool:
        """Return whether a length, eye distances, arrives too far from the one sent."""
        return abs(received - sent) > self.max_error

    def errors(
        self,
        transform: MotionTransform,
        frames: Sequence[MotionFrame],
        coded: Sequence[QuantisedFrame],
        earlier: Sequence[QuantisedFrame],
        /,
    ) -> list[float]:
        """Return by how much each frame is shown too long, eye distances; 0 if that is little enough.

        coded : the frames as they would be sent; earlier : those one, two, ... strides before the first
        """
        known, errors = list(earlier), []
        for frame, quantised in zip(frames, coded, strict=True):
            sent = float(frame.displacements.reshape(-1) @ self.gradient)
            received = float(transform.shown_values(quantised, known)[POSE_VALUES:] @ self.by_component)
            for point, steps in quantised.residuals.items():
                received += float(self.gradient[3 * point : 3 * point + 3] @ (transform.residual_steps[point] * steps))
            errors.append(received - sent if self.is_too_far(sent, received) else 0.0)
            known = [quantised, *known[: HISTORY - 1]]
        return errors

    def correct(self, frames: Sequence[MotionFrame], errors: Sequence[float], /) -> list[MotionFrame]:
        """Return targets whose lengths are shorter by the errors."""
        shifts = [(error * self.direction).reshape(-1, 3).astype(np.float32) for error in errors]
        return [
            replace(frame, displacements=frame.displacements - shift)
            for frame, shift in zip(frames, shifts, strict=True)
        ]


def by_component_and_direction(
    gradient: NDArray[np.float64], transform: MotionTransform, /
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the fields `by_component` and `direction` of a curve with a gradient (3 n,)."""
    by_component = transform.inverse_matrix @ gradient
    return by_component, by_component / (by_component @ by_component) @ transform.inverse_matrix
