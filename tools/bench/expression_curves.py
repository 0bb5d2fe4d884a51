"""Curves that describe an expression, each a weighted sum of coordinates of the control points.

A viewer reads an expression from differences of points: how far a brow is raised, how near the brows are to each other,
how thick a lip is. Each curve is such a difference, so one matrix measures it on landmarks, on decoded control points
and on the vertices of a drawn head, and serves the training of the codec as the gradient of the curve. Lengths are
divided by the distance of the outer eye corners. Brows are measured from the bridge of the nose, which no expression
moves: a blink moves the tracked corners of the eyes by 1 to 3 mm, which would read as a raised brow.
"""

import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_COUNT, CONTROL_POINT_INDEX

BRIDGE_LANDMARK = 168  # bridge of the nose
_AXES = {"x": 0, "y": 1, "z": 2}
# Curve: coordinates, each with its sign. Left is the subject's.
_TABLE = """
brow_inner_l        +y.brow_inner_l
brow_inner_r        +y.brow_inner_r
brow_outer_l        +y.brow_top_l
brow_outer_r        +y.brow_top_r
brow_knit           +x.brow_inner_l -x.brow_inner_r
brow_slant_l        +y.brow_inner_l -y.brow_top_l
brow_slant_r        +y.brow_inner_r -y.brow_top_r
mouth_opening       +y.inner_lip_upper_mid -y.inner_lip_lower_mid
mouth_width         +x.outer_lip_corner_l -x.outer_lip_corner_r
lip_corner_l        +y.outer_lip_corner_l
lip_corner_r        +y.outer_lip_corner_r
upper_lip_thickness +y.outer_lip_upper_mid -y.inner_lip_upper_mid
lower_lip_thickness +y.inner_lip_lower_mid -y.outer_lip_lower_mid
upper_lip_raise     +y.outer_lip_upper_mid -y.nose_bottom_edge_l/2 -y.nose_bottom_edge_r/2
lid_l               +y.eyelid_upper_l -y.eyelid_lower_l
lid_r               +y.eyelid_upper_r -y.eyelid_lower_r
gaze_x              +x.pupil_l/2 +x.pupil_r/2
gaze_y              +y.pupil_l/2 +y.pupil_r/2
vergence_x          +x.pupil_l/2 -x.pupil_r/2
vergence_y          +y.pupil_l/2 -y.pupil_r/2
"""


def _gradient(terms: str) -> NDArray[np.float64]:
    gradient = np.zeros((CONTROL_POINT_COUNT, 3))
    for term in terms.split():
        name, _, divisor = term[1:].partition("/")
        axis, _, point = name.partition(".")
        gradient[CONTROL_POINT_INDEX[point], _AXES[axis]] += (1 if term[0] == "+" else -1) / float(divisor or 1)
    return gradient


_ROWS = [line.split(maxsplit=1) for line in _TABLE.strip().splitlines()]
NAMES = tuple(name for name, _ in _ROWS)
GRADIENTS = np.stack([_gradient(terms) for _, terms in _ROWS])  # (curves, n, 3)
# Curves of the report: those of both sides are averaged.
REPORTED = {
    "inner brow": ("brow_inner_l", "brow_inner_r"),
    "outer brow": ("brow_outer_l", "brow_outer_r"),
    "knit": ("brow_knit",),
    "slant": ("brow_slant_l", "brow_slant_r"),
    "mouth opening": ("mouth_opening",),
    "mouth width": ("mouth_width",),
    "upper lip thickness": ("upper_lip_thickness",),
    "lower lip thickness": ("lower_lip_thickness",),
    "upper-lip raise": ("upper_lip_raise",),
    "lids": ("lid_l", "lid_r"),
    "gaze x": ("gaze_x",),
    "gaze y": ("gaze_y",),
}
_AVERAGE = np.array([[(name in names) / len(names) for name in NAMES] for names in REPORTED.values()])
_EYES = [CONTROL_POINT_INDEX["eye_outer_corner_l"], CONTROL_POINT_INDEX["eye_outer_corner_r"]]


def reported_curves(points: NDArray[np.floating], /) -> NDArray[np.float64]:
    """Return the (N, R) curves of REPORTED, in distances of the outer eye corners in the median frame.

    points : (N, n, 3) positions with the head pose removed, any length unit; brows relative to the bridge of the nose,
        pupils relative to the middle of the corners of their eye
    """
    unit = np.median(np.linalg.norm(points[:, _EYES[0]] - points[:, _EYES[1]], axis=1))
    return np.asarray(np.einsum("ni,ri->nr", points.reshape(len(points), -1), _AVERAGE @ _flat()) / unit)


def _flat() -> NDArray[np.float64]:
    return GRADIENTS.reshape(len(NAMES), -1)
