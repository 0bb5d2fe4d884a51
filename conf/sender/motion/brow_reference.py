"""Measure brows from the bridge of the nose, from which viewers read them.

The bridge as tracked moves by 0.9 mm in speech, partly with the head pose, which smiles and blinks disturb. That of a
drawn head follows what its control points do: BRIDGE_WEIGHTS. So brows are sent moved by the difference of the two, and
the distance from brow to bridge that is drawn is the one that was filmed.
"""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_COUNT, CONTROL_POINT_LANDMARKS, control_point_indices
from conf.sender.motion.mean_face import MEAN_FACE

BRIDGE_LANDMARK = 168
_MEAN_BRIDGE_CM = 3.23  # height of the bridge in the frames of mean_face.py
# By how much the bridge of a drawn head rises with each control point, of the default head's operator.
BRIDGE_WEIGHTS: Mapping[str, float] = {
    "eye_inner_corner": 0.23, "eye_outer_corner": -0.04, "eye_upper_outer_lid": 0.04, "eyelid_upper": -0.03,
    "brow_inner": 0.14, "brow_outer": 0.02, "nose_bottom_edge": -0.10, "nostril_border": 0.055,
}  # fmt: skip
_BROWS = control_point_indices("brow")
_WEIGHTS = np.zeros(CONTROL_POINT_COUNT)
for _name, _weight in BRIDGE_WEIGHTS.items():
    _WEIGHTS[control_point_indices(_name)] = _weight


def points_with_brows_from_bridge(aligned: NDArray[np.float64], /) -> NDArray[np.float64]:
    """Return the control points (n, 3), brows as far above the bridge that will be drawn as above the tracked one.

    aligned : (478, 3) landmarks in cm, head pose removed
    """
    points: NDArray[np.float64] = aligned[CONTROL_POINT_LANDMARKS]
    excess = aligned[BRIDGE_LANDMARK, 1] - _MEAN_BRIDGE_CM - float(_WEIGHTS @ (points[:, 1] - MEAN_FACE[:, 1]))
    points[_BROWS, 1] -= excess / (1 - float(_WEIGHTS[_BROWS].sum()))  # the brows that move take the bridge with them
    return points
