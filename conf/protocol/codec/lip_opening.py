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

from conf.protocol.codec.reference_frames import QuantisedFrame
from conf.protocol.codec.transform import MotionTransform
from conf.protocol.messages import MotionFrame

# Eye distances; 0.0115 is 1 mm. A head draws an opening of up to 0.9 mm as none, and one of 1.75 mm as 1 mm.
MAX_ERROR = 0.0115
NEARLY_SHUT = 0.0125  # openings below this are shown ...
MAX_SHOWN_SHUT = 0.0165  # ... at most this far open


@dataclass(frozen=True)
class LipOpening:
    """The opening of the mouth as a linear function of displacements.

    gradient : (3 n,) eye distances per FAPU unit
    direction : (3 n,) FAPU units per eye distance: opens the mouth with the smallest change of the components
    """

    gradient: NDArray[np.float64]
    direction: NDArray[np.float64]

    @classmethod
    def build(cls, gradient: NDArray[np.float64], transform: MotionTransform, /) -> "LipOpening":
        """Return the opening with its direction in the learned space."""
        by_component = transform.inverse_matrix @ gradient
        return cls(gradient, by_component / (by_component @ by_component) @ transform.inverse_matrix)

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
            shown, _ = transform.inverse(quantised, known)
            sent, received = (float(points.reshape(-1) @ self.gradient) for points in (frame.displacements, shown))
            opens = sent < NEARLY_SHUT and received > MAX_SHOWN_SHUT
            errors.append(received - sent if opens or abs(received - sent) > MAX_ERROR else 0.0)
            known.insert(0, quantised)
        return errors

    def correct(self, frames: Sequence[MotionFrame], errors: Sequence[float], /) -> list[MotionFrame]:
        """Return targets whose mouths are less open by the errors."""
        shifts = [(error * self.direction).reshape(-1, 3).astype(np.float32) for error in errors]
        return [
            replace(frame, displacements=frame.displacements - shift)
            for frame, shift in zip(frames, shifts, strict=True)
        ]
