"""Keep the decoded opening of the mouth near the one sent: shut lips stay shut, and open lips stay open.

A millimetre between lips that touch opens a shut mouth, and one less hides a short vowel. So the opening is corrected
where it is too far off: see mouth_curve.py.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from conf.protocol.codec.mouth_curve import MouthCurve, by_component_and_direction
from conf.protocol.codec.transform import MotionTransform

# Eye distances; 0.0105 is 0.9 mm. A head draws an opening of up to 0.9 mm as none, and one of 1.75 mm as 1 mm.
MAX_ERROR = 0.0105
MAX_ERROR_STEPS = 1.1  # at least: coarser profiles would correct every second frame
NEARLY_SHUT = 0.0125  # openings below this are shown ...
MAX_SHOWN_SHUT = 0.0165  # ... at most this far open


@dataclass(frozen=True)
class LipOpening(MouthCurve):
    """The opening of the mouth as a linear function of displacements."""

    @classmethod
    def build(cls, gradient: NDArray[np.float64], transform: MotionTransform, /, *, step: float) -> "LipOpening":
        """Return the opening with its direction in the learned space. step : of the profile, eye distances"""
        by_component, direction = by_component_and_direction(gradient, transform)
        return cls(gradient, by_component, max(MAX_ERROR, MAX_ERROR_STEPS * step), direction)

    def is_too_far(self, sent: float, received: float, /) -> bool:
        """Return whether an opening arrives too far from the one sent, or a mouth that is nearly shut arrives open."""
        return (sent < NEARLY_SHUT and received > MAX_SHOWN_SHUT) or super().is_too_far(sent, received)
