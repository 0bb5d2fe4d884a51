"""Show as much of the upper teeth as speech and smiles show of people's.

Sculpted incisors hang below the upper lip by up to 4 mm, where those of people who speak are hidden behind it: every
slight opening would show a white band. So the teeth are raised until the lip covers them, by less when the lip is
raised from them, when the corners of the mouth are drawn apart, or when the mouth is wide open.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_INDEX

_HIDDEN_CM = 0.05  # by which the lip covers teeth that are not to be seen
_REST_OVERHANG_CM = 0.13  # of people's incisors below a parted lip at rest: the teeth are never drawn lower
_LIP_RAISE_CM = 0.08  # of the upper lip from which on it uncovers the teeth
_SMILE_CM = 0.25  # by which the corners of the mouth move apart before the teeth are uncovered
_SMILE_RATE = 0.5  # cm of teeth a cm more of width
_OPENING_CM = (0.5, 1.2)  # from lip to lip, over which teeth are uncovered as far as at rest
_UPPER, _LOWER, _LEFT, _RIGHT = (
    CONTROL_POINT_INDEX[f"inner_lip_{at}"] for at in ("upper_mid", "lower_mid", "corner_l", "corner_r")
)
_MIDDLE = 0.25  # of the width of the teeth, to either side, in which the lowest vertex is an incisor's edge


@dataclass(frozen=True)
class UpperTeeth:
    """The upper teeth. vertices : (k,); overhang : cm of the incisors' edge below the upper lip, neutral"""

    vertices: NDArray[np.int64]
    overhang: float

    def rise(self, offsets: NDArray[np.floating], /) -> float:
        """Return how far up the teeth have to move, cm. offsets : (n, 3) of the control points, model centimetres"""
        lip, lower = float(offsets[_UPPER, 1]), float(offsets[_LOWER, 1])
        wider = float(offsets[_LEFT, 0] - offsets[_RIGHT, 0])
        start, end = _OPENING_CM
        open_share = min(max((lip - lower - start) / (end - start), 0.0), 1.0)
        shown = max(lip - _LIP_RAISE_CM, 0.0) + _SMILE_RATE * max(wider - _SMILE_CM, 0.0)
        shown += open_share * (_REST_OVERHANG_CM + _HIDDEN_CM) - _HIDDEN_CM
        return max(self.overhang + lip - shown, self.overhang - _REST_OVERHANG_CM, 0.0)


def find_upper_teeth(
    vertices: NDArray[np.float64], teeth: NDArray[np.int64], points: NDArray[np.float64], /
) -> UpperTeeth | None:
    """Return the upper teeth of a mesh, None if it has none.

    vertices : (V, 3), teeth : (k,) of them, points : (n, 3) control points, all neutral, model centimetres
    """
    if not len(teeth):
        return None
    positions = vertices[teeth]
    middle = np.abs(positions[:, 0] - points[_UPPER, 0]) <= _MIDDLE * np.ptp(positions[:, 0])
    edge = float(positions[middle, 1].min(initial=np.inf))
    return UpperTeeth(teeth, float(points[_UPPER, 1]) - edge) if np.isfinite(edge) else None
