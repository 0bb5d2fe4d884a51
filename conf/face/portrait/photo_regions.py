"""What keeps the lips of a photograph apart: two fields over the mesh, blended by the distance to either lip or lid."""

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from conf.face.control_points import LOWER_LID, LOWER_LIP, UPPER_LID, UPPER_LIP
from conf.face.deformation.regions import InfluenceField, Regions
from conf.face.interpolation import smoothstep
from conf.face.portrait import contours

SHARPNESS = 0.9  # how fast one field gives way to the other, as on the head
REACH_CM = {"mouth": 6.0, "eye": 3.0}  # beyond it both fields count alike

_MOUTH = (contours.UPPER_OUTER_LIP + contours.UPPER_INNER_LIP, contours.LOWER_OUTER_LIP + contours.LOWER_INNER_LIP)
_EYES = (contours.UPPER_LID_R + contours.UPPER_LID_L, contours.LOWER_LID_R + contours.LOWER_LID_L)


def split_photo_regions(flat: NDArray[np.float64], /) -> Regions:
    """Divide a photograph's mesh at mouth and eyes.

    flat : (V, 2) cm, picture axes; the first D are contours.ALL
    Returns four fields without anchors, as conf.face.deformation.regions.split_regions does for a head.
    """
    mouth = _lower_share(flat, _MOUTH, REACH_CM["mouth"])
    eyes = _lower_share(flat, _EYES, REACH_CM["eye"])
    fields = (
        InfluenceField((1 - mouth) * (1 - eyes), (*LOWER_LIP, *LOWER_LID)),
        InfluenceField((1 - mouth) * eyes, (*LOWER_LIP, *UPPER_LID)),
        InfluenceField(mouth * (1 - eyes), (*UPPER_LIP, *LOWER_LID)),
        InfluenceField(mouth * eyes, (*UPPER_LIP, *UPPER_LID)),
    )
    return Regions(fields, np.empty((0, 3)))


def _lower_share(
    flat: NDArray[np.float64], sides: tuple[tuple[int, ...], tuple[int, ...]], reach: float
) -> NDArray[np.float64]:
    """Return (V,): 0 beside the upper lips or lids, 1 beside the lower ones, a half at the corners and far away."""
    shared = set(sides[0]) & set(sides[1])
    rows = [contours.landmark_rows(tuple(i for i in side if i not in shared)) for side in sides]
    upper, lower = (cKDTree(flat[side]).query(flat)[0] for side in rows)
    lean = (upper - lower) / np.maximum(upper + lower, 1e-9)
    near = np.clip(2 * (1 - np.minimum(upper, lower) / reach), 0, 1)
    share = smoothstep(0.5 + SHARPNESS * near * lean)
    share[rows[0]], share[rows[1]], share[contours.landmark_rows(tuple(shared))] = 0.0, 1.0, 0.5
    return np.asarray(share)
