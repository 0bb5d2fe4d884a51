"""The tracker's landmarks that outline a photographed face, in addition to the fifty control points.

The control points do not say where the lips part or where the lids begin. The outlines do, and are sent once with the
photo. Numbers are indices of the tracker's landmarks. Left and right are the subject's.
Source: MediaPipe, face_mesh_connections.py.
"""

import numpy as np

from conf.face.control_points import CONTROL_POINT_LANDMARKS

UPPER_INNER_LIP = (78, 191, 80, 81, 82, 13, 312, 311, 310, 415, 308)  # from corner to corner
LOWER_INNER_LIP = (78, 95, 88, 178, 87, 14, 317, 402, 318, 324, 308)
UPPER_OUTER_LIP = (61, 185, 40, 39, 37, 0, 267, 269, 270, 409, 291)
LOWER_OUTER_LIP = (61, 146, 91, 181, 84, 17, 314, 405, 321, 375, 291)
UPPER_LID_R = (33, 246, 161, 160, 159, 158, 157, 173, 133)  # from the outer corner to the inner
LOWER_LID_R = (33, 7, 163, 144, 145, 153, 154, 155, 133)
UPPER_LID_L = (263, 466, 388, 387, 386, 385, 384, 398, 362)
LOWER_LID_L = (263, 249, 390, 373, 374, 380, 381, 382, 362)
BROW_R = (70, 63, 105, 66, 107, 55, 65, 52, 53, 46)
BROW_L = (300, 293, 334, 296, 336, 285, 295, 282, 283, 276)
NOSE = (168, 6, 197, 195, 5, 4, 1, 2, 48, 278, 98, 327)
OVAL = (
    10, 338, 297, 332, 284, 251, 389, 356, 454, 323, 361, 288, 397, 365, 379, 378, 400, 377,
    152, 148, 176, 149, 150, 136, 172, 58, 132, 93, 234, 127, 162, 21, 54, 103, 67, 109,
)  # fmt: skip

# Groups of landmarks that are close together, so that each point needs few bits within its group's bounding box.
GROUPS = (
    UPPER_INNER_LIP + LOWER_INNER_LIP + UPPER_OUTER_LIP + LOWER_OUTER_LIP,
    UPPER_LID_R + LOWER_LID_R + BROW_R,
    UPPER_LID_L + LOWER_LID_L + BROW_L,
    NOSE,
    OVAL,
)


def _extra_groups() -> tuple[tuple[int, ...], ...]:
    """Return the landmarks of each group that are neither control points nor in an earlier group."""
    known = set(CONTROL_POINT_LANDMARKS.tolist())
    groups = []
    for group in GROUPS:
        groups.append(tuple(i for i in dict.fromkeys(group) if i not in known))
        known.update(group)
    return tuple(groups)


EXTRA_GROUPS = _extra_groups()
CONTOUR_LANDMARKS = np.array([i for group in EXTRA_GROUPS for i in group])
# (D,) landmarks of a photographed face: the control points, then the outlines
PORTRAIT_LANDMARKS = np.concatenate([CONTROL_POINT_LANDMARKS, CONTOUR_LANDMARKS])
_ROW = {int(landmark): row for row, landmark in enumerate(PORTRAIT_LANDMARKS)}


def landmark_rows(landmarks: tuple[int, ...], /) -> list[int]:
    """Return the rows of landmarks in PORTRAIT_LANDMARKS."""
    return [_ROW[i] for i in landmarks]


OVAL_ROWS = landmark_rows(OVAL)
