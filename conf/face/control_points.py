"""The fifty control points: MPEG-4 feature points and the tracker landmark that gives each.

Left and right are the subject's. The head pose (feature point 7.1) is transmitted separately.
Source: ISO/IEC 14496-2, Annex C (feature points); MediaPipe's face mesh with irises (landmark numbers).
"""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class ControlPoint:
    """A control point: its row in every array, its MPEG-4 number, its name and its landmark."""

    index: int
    feature_point: str
    name: str
    landmark: int


_TABLE = """
2.1   chin_bottom              152
2.2   inner_lip_upper_mid      13
2.3   inner_lip_lower_mid      14
2.4   inner_lip_corner_l       308
2.5   inner_lip_corner_r       78
2.6   inner_lip_upper_l        311
2.7   inner_lip_upper_r        81
2.8   inner_lip_lower_l        402
2.9   inner_lip_lower_r        178
2.10  chin_boss                199
2.11  chin_corner_l            400
2.12  chin_corner_r            176
3.1   eyelid_upper_l           386
3.2   eyelid_upper_r           159
3.3   eyelid_lower_l           374
3.4   eyelid_lower_r           145
3.5   pupil_l                  473
3.6   pupil_r                  468
3.7   eye_outer_corner_l       263
3.8   eye_inner_corner_r       133
3.9   eye_lower_outer_lid_l    253
3.10  eye_lower_outer_lid_r    23
3.11  eye_inner_corner_l       362
3.12  eye_outer_corner_r       33
3.13  eye_upper_outer_lid_l    257
3.14  eye_upper_outer_lid_r    27
4.1   brow_inner_l             336
4.2   brow_inner_r             107
4.3   brow_top_l               334
4.4   brow_top_r               105
4.5   brow_outer_l             300
4.6   brow_outer_r             70
5.1   cheek_center_l           425
5.2   cheek_center_r           205
5.3   cheekbone_l              280
5.4   cheekbone_r              50
8.1   outer_lip_upper_mid      0
8.2   outer_lip_lower_mid      17
8.3   outer_lip_corner_l       291
8.4   outer_lip_corner_r       61
8.5   outer_lip_upper_l        269
8.6   outer_lip_upper_r        39
8.7   outer_lip_lower_l        405
8.8   outer_lip_lower_r        181
8.9   cupids_bow_r             37
8.10  cupids_bow_l             267
9.1   nostril_border_l         358
9.2   nostril_border_r         129
9.4   nose_bottom_edge_r       98
9.5   nose_bottom_edge_l       327
"""


def _parse_table(table: str) -> tuple[ControlPoint, ...]:
    rows = (line.split() for line in table.strip().splitlines())
    return tuple(ControlPoint(i, point, name, int(landmark)) for i, (point, name, landmark) in enumerate(rows))


CONTROL_POINTS = _parse_table(_TABLE)
CONTROL_POINT_COUNT = len(CONTROL_POINTS)
CONTROL_POINT_LANDMARKS = np.array([point.landmark for point in CONTROL_POINTS])  # (n,) rows of the tracker's output
CONTROL_POINT_INDEX = {point.name: point.index for point in CONTROL_POINTS}


def control_point_indices(*prefixes: str) -> list[int]:
    """Return the indices of the control points whose name starts with one of the prefixes, in order."""
    return [point.index for point in CONTROL_POINTS if point.name.startswith(prefixes)]


UPPER_LIP = control_point_indices("inner_lip_upper", "outer_lip_upper", "cupids_bow")
LOWER_LIP = control_point_indices("inner_lip_lower", "outer_lip_lower")
UPPER_LID = control_point_indices("eyelid_upper", "eye_upper_outer_lid")
LOWER_LID = control_point_indices("eyelid_lower", "eye_lower_outer_lid")
PUPILS = control_point_indices("pupil")
# Of the left and the right eye.
EYE_CORNERS = [[CONTROL_POINT_INDEX[f"eye_{at}_corner_{side}"] for at in ("inner", "outer")] for side in "lr"]
# The inner edge of either lip, from the right corner of the mouth to the left one.
UPPER_LIP_EDGE, LOWER_LIP_EDGE = (
    [CONTROL_POINT_INDEX[f"inner_lip_{at}"] for at in ("corner_r", f"{lip}_r", f"{lip}_mid", f"{lip}_l", "corner_l")]
    for lip in ("upper", "lower")
)
