"""Keep shut lips shut, and lips that press each other from passing through each other.

Coding and tracking noise move a lip by up to half a millimetre, which draws a dark line between shut lips. A distance
from lip to lip of less than CLOSED_CM is therefore drawn as none. Both lips give way by half of the change, with their
outer edges, so that they keep their thickness.

Shut lips of a person who speaks are tracked 1.2 mm apart, as landmarks are smoothed: what is sent of them is shut as
well, or the noise of the codec would open them.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_INDEX
from conf.face.interpolation import smoothstep

CLOSED_CM = 0.09  # from lip to lip, of shut lips with noise; 6.4 cm between the pupils
_OPEN_CM = 0.26  # at which the distance is drawn in full
_SENT_CM = (0.12, 0.22)  # tracked distances up to which none is sent, and from which on all of it
_MAX_NEUTRAL_GAP_CM = 0.25  # of a neutral mouth that counts as shut
_MAX_OVERLAP_CM = 0.03  # by which lips are pressed together
_COLUMNS = ("mid", "l", "r")
_INNER = np.array([[CONTROL_POINT_INDEX[f"inner_lip_{lip}_{at}"] for at in _COLUMNS] for lip in ("upper", "lower")])
_OUTER = np.array([[CONTROL_POINT_INDEX[f"outer_lip_{lip}_{at}"] for at in _COLUMNS] for lip in ("upper", "lower")])
_BOW = [CONTROL_POINT_INDEX["cupids_bow_l"], CONTROL_POINT_INDEX["cupids_bow_r"]]


def keep_lips_shut(points: NDArray[np.float64], offsets: NDArray[np.float32], /) -> NDArray[np.float32]:
    """Return the offsets of the control points, with a mouth that is nearly shut shut.

    points, offsets : (n, 3) neutral control points and their offsets, model centimetres
    """
    upper, lower = _INNER
    opening = offsets[upper, 1] - offsets[lower, 1]
    if (opening >= _OPEN_CM).all() or points[upper[0], 1] - points[lower[0], 1] > _MAX_NEUTRAL_GAP_CM:
        return offsets
    return _with_opening(offsets, opening, drawn_opening(opening))


def send_lips_shut(offsets: NDArray[np.float64], /) -> NDArray[np.float64]:
    """Return tracked offsets (n, 3) of the control points, cm from a neutral pose with shut lips, to be sent."""
    upper, lower = _INNER
    opening = offsets[upper, 1] - offsets[lower, 1]
    start, end = _SENT_CM
    return _with_opening(offsets, opening, np.minimum(opening, opening * smoothstep((opening - start) / (end - start))))


def _with_opening(
    offsets: NDArray[np.floating], opening: NDArray[np.floating], shown: NDArray[np.floating]
) -> NDArray[Any]:
    """Return offsets (n, 3) with other distances (3,) from lip to lip; each lip gives way by half."""
    excess = opening - shown
    if not excess.any():
        return offsets
    half = (excess / 2).astype(offsets.dtype)
    kept = offsets.copy()
    for lips in (_INNER, _OUTER):
        kept[lips[0], 1] -= half
        kept[lips[1], 1] += half
    kept[_BOW, 1] -= (half[0] + half[1:]) / 2
    return kept


def drawn_opening(opening: NDArray[np.floating], /) -> NDArray[np.float64]:
    """Return the distance to draw from lip to lip, cm: none below CLOSED_CM, in full from _OPEN_CM on."""
    shown = opening * smoothstep((opening - CLOSED_CM) / (_OPEN_CM - CLOSED_CM))
    return np.asarray(np.where(opening < 0, np.maximum(opening, -_MAX_OVERLAP_CM), shown))
