"""The mean neutral face, used until a person's neutral pose is known.

The canonical face is worse: on real people the tracker puts lids 4 mm higher, the fold of the upper lid 8 mm, and the
canonical lips are parted. These are the positions in the quiet frames of 25 clips of different people, head pose
removed, mouth shut, left and right averaged.
"""

import numpy as np

from conf.face.control_points import CONTROL_POINT_COUNT, CONTROL_POINT_INDEX

# cm in face axes: x to the subject's left, y up, z to the viewer; the right side mirrors the left one
_TABLE = """
chin_bottom               0.00  -9.07  3.97
inner_lip_upper_mid       0.00  -4.30  5.51
inner_lip_lower_mid       0.00  -4.34  5.42
inner_lip_corner_l        2.34  -4.48  4.26
inner_lip_upper_l         1.17  -4.29  5.19
inner_lip_lower_l         1.17  -4.33  5.10
chin_boss                 0.00  -7.88  5.03
chin_corner_l             2.29  -8.58  3.26
eyelid_upper_l            3.47   3.38  3.83
eyelid_lower_l            3.32   2.37  3.75
pupil_l                   3.32   2.92  3.56
eye_outer_corner_l        4.62   2.76  2.98
eye_lower_outer_lid_l     3.30   1.99  3.84
eye_inner_corner_l        1.77   2.55  3.57
eye_upper_outer_lid_l     3.71   4.09  4.03
brow_inner_l              1.56   5.12  5.32
brow_top_l                4.41   5.36  4.37
brow_outer_l              5.99   4.34  2.83
cheek_center_l            4.14  -1.63  4.35
cheekbone_l               5.05  -0.74  3.76
outer_lip_upper_mid       0.00  -3.66  6.08
outer_lip_lower_mid       0.00  -5.39  5.57
outer_lip_corner_l        2.59  -4.49  4.07
outer_lip_upper_l         1.48  -3.76  5.61
outer_lip_lower_l         1.47  -5.09  5.24
cupids_bow_l              0.76  -3.52  5.99
nostril_border_l          2.04  -1.14  4.79
nose_bottom_edge_l        1.63  -1.84  5.20
"""

MEAN_FACE = np.zeros((CONTROL_POINT_COUNT, 3))  # (n, 3) float64
for _name, *_values in map(str.split, _TABLE.strip().splitlines()):
    _point = np.array([float(value) for value in _values])
    MEAN_FACE[CONTROL_POINT_INDEX[_name]] = _point
    if _name.endswith("_l"):
        MEAN_FACE[CONTROL_POINT_INDEX[_name[:-1] + "r"]] = _point * (-1, 1, 1)
