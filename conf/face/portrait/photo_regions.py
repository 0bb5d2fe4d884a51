"""Influence regions of a photo's mesh: the control points of one lip or lid do not move the other one."""

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from conf.face.deformation.regions import Regions, blend_fields
from conf.face.interpolation import smoothstep
from conf.face.portrait import contours

SHARPNESS = 0.9  # slope of the transition between the regions, as on the head
REACH_CM = {"mouth": 6.0, "eye": 3.0}  # beyond it both regions have equal weights

_MOUTH = (contours.UPPER_OUTER_LIP + contours.UPPER_INNER_LIP, contours.LOWER_OUTER_LIP + contours.LOWER_INNER_LIP)
_EYES = (contours.UPPER_LID_R + contours.UPPER_LID_L, contours.LOWER_LID_R + contours.LOWER_LID_L)


def split_photo_regions(positions_cm: NDArray[np.float64], /) -> Regions:
    """Return four fields of V vertices without anchors, as conf.face.deformation.regions.split_regions for a head."""
    mouth = _lower_weight(positions_cm, _MOUTH, REACH_CM["mouth"])
    eyes = _lower_weight(positions_cm, _EYES, REACH_CM["eye"])
    return Regions(blend_fields(mouth, eyes), np.empty((0, 3)))


def _lower_weight(
    positions_cm: NDArray[np.float64], sides: tuple[tuple[int, ...], tuple[int, ...]], reach: float
) -> NDArray[np.float64]:
    """Return (V,): 0 at the upper lip or lids, 1 at the lower ones, 0.5 at the corners and far away."""
    common = set(sides[0]) & set(sides[1])
    rows = [contours.landmark_rows(tuple(i for i in side if i not in common)) for side in sides]
    upper, lower = (cKDTree(positions_cm[side]).query(positions_cm)[0] for side in rows)
    balance = (upper - lower) / np.maximum(upper + lower, 1e-9)
    near = np.clip(2 * (1 - np.minimum(upper, lower) / reach), 0, 1)
    weight = smoothstep(0.5 + SHARPNESS * near * balance)
    weight[rows[0]], weight[rows[1]], weight[contours.landmark_rows(tuple(common))] = 0.0, 1.0, 0.5
    return np.asarray(weight)
