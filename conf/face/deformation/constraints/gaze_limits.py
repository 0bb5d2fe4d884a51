"""Turn eyeballs so that the pupil is where the sender measured it: relative to the corners of its eye.

The corners of an eye move with the face by a few millimetres, and the sender measures the pupil from their middle. So
the pupil follows the corners as they are drawn. Then it is kept where its eye can show it: at most MAX_SIDEWAYS_CM and
MAX_UPRIGHT_CM from its neutral position, and between the lids while they are open.
"""

import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_INDEX, PUPILS
from conf.face.interpolation import smoothstep

MAX_SIDEWAYS_CM = 0.6  # 6.4 cm between the pupils: a pupil farther off is hidden by the corner of its eye
MAX_UPRIGHT_CM = 0.4
_MARGIN = 0.08  # of the slit, from either lid to the middle of the pupil: half of the iris is seen
_SHUT, _OPEN = 0.3, 0.6  # of the neutral slit: at which the slit begins to limit the pupil, and limits it entirely
_LIDS = {
    pupil: [CONTROL_POINT_INDEX[f"eyelid_{lid}_{side}"] for lid in ("upper", "lower")]
    for pupil, side in zip(PUPILS, "lr", strict=True)
}


def limit_gaze(
    pupil: int, points: NDArray[np.float64], offsets: NDArray[np.floating], corners: NDArray[np.floating], /
) -> NDArray[np.float64]:
    """Return the (3,) offset of a pupil that is drawn.

    pupil : index of its control point
    points, offsets : (n, 3) neutral control points and their offsets, model centimetres; a pupil's is relative to the
        middle of the corners of its eye
    corners : (3,) offset of that middle
    """
    x, y = offsets[pupil, :2].tolist()
    x = float(corners[0]) + min(max(x, -MAX_SIDEWAYS_CM), MAX_SIDEWAYS_CM)
    y = float(corners[1]) + min(max(y, -MAX_UPRIGHT_CM), MAX_UPRIGHT_CM)
    lids = points[_LIDS[pupil], 1]
    upper, lower = (lids + offsets[_LIDS[pupil], 1]).tolist()
    slit, neutral_slit = max(upper - lower, 0.0), max(float(lids[0] - lids[1]), 1e-6)
    height = float(points[pupil, 1]) + y
    inside = min(max(height, lower + _MARGIN * slit), upper - _MARGIN * slit)
    weight = float(smoothstep((slit / neutral_slit - _SHUT) / (_OPEN - _SHUT)))
    return np.array([x, y + weight * (inside - height), 0.0])
