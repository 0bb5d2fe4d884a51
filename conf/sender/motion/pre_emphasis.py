"""Emphasise small movements before they are sent, so that they are drawn as large as they were filmed.

Strategy. Smoothing, rounding and the operator of a head each take a few per cent of a brow's raise, a frown, the
thickness of a lip and the closing of an eye, and little of an opening mouth or a smile. What is lost is nearly the same
for everybody, so it is added before coding, where it also stands out from the rounding; it costs 0.01 kbit/s. The gains
make up for what medians of drawn vertices over tracked landmarks lacked (tools/bench/fidelity_tracks.py). Leaving out
any one person moves these medians by at most 0.03, that of the slant, which only five people move, by 0.05.
Source: pre-emphasis before a lossy channel, as in Jayant, Noll 1984.
"""

import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_COUNT, CONTROL_POINT_INDEX, control_point_indices

LID_GAIN = 1.07  # of the change of an eye's opening; without it 0.93 is drawn; a shut eye is drawn shut already
LIP_GAIN = 1.05  # of the change of a lip's thickness; without it 0.80
BROW_GAIN_X, BROW_GAIN_Y = 1.1, 1.03  # without them knit 0.74; slant 0.88
PUPIL_GAIN_X = 1.02  # gaze to the side 0.92 to 0.94

_X, _Y = 0, 1
_GAINS = np.ones((CONTROL_POINT_COUNT, 3))
_GAINS[control_point_indices("brow"), _X] = BROW_GAIN_X
_GAINS[control_point_indices("brow"), _Y] = BROW_GAIN_Y
_GAINS[control_point_indices("pupil"), _X] = PUPIL_GAIN_X
# Points of the outer edge of a lip, and that of its inner edge which is nearest.
_LIP_EDGES = [
    (CONTROL_POINT_INDEX[f"outer_lip_{lip}_{at}"], CONTROL_POINT_INDEX[f"inner_lip_{lip}_{at}"])
    for lip in ("upper", "lower")
    for at in ("mid", "l", "r")
] + [(point, CONTROL_POINT_INDEX["inner_lip_upper_mid"]) for point in control_point_indices("cupids_bow")]
_OUTER, _INNER = (list(points) for points in zip(*_LIP_EDGES, strict=True))


def emphasise(displacements: NDArray[np.float64], /) -> NDArray[np.float64]:
    """Return displacements (n, 3), any unit, with larger movements of brows, pupils and the outer edges of the lips.

    Inner lips stay: the mouth opens as far as before, and shut lips are shut.
    """
    emphasised: NDArray[np.float64] = displacements * _GAINS
    emphasised[_OUTER, _Y] += (LIP_GAIN - 1) * (displacements[_OUTER, _Y] - displacements[_INNER, _Y])
    return emphasised


def emphasise_openness(openness: NDArray[np.float64], /) -> NDArray[np.float64]:
    """Return the openness (2,) of the eyes to send: 0 shut, 1 as in the neutral pose, which both stay."""
    return np.asarray(np.maximum(1 + LID_GAIN * (openness - 1), 0.0))
