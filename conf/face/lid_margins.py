"""The edges of the lids, between the control points.

An upper lid has one control point on its edge, at the middle; its ends are the corners of the eye. Interpolated
between these alone an eye shuts like a V. A lid's edge is close to a parabola through the three, and so is the gap
between two of them: helper points on it, moved by the same parabola, shut an eye over its whole width. Place and
displacement of a helper point are fixed mixtures of three control points, so they fold into the operator.
"""

import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_COUNT, INDEX
from conf.face.regions import Field, Regions

_ALONG = (-0.75, -0.4, 0.4, 0.75)  # where on the edge, from -1 at the outer corner to 1 at the inner


def _mixtures() -> tuple[NDArray[np.float64], list[int]]:
    rows, owners = [], []
    for lid in ("eyelid_upper_l", "eyelid_upper_r", "eyelid_lower_l", "eyelid_lower_r"):
        for s in _ALONG:
            row = np.zeros(CONTROL_POINT_COUNT)
            row[INDEX[f"eye_outer_corner_{lid[-1]}"]] = s * (s - 1) / 2
            row[INDEX[lid]] = 1 - s * s
            row[INDEX[f"eye_inner_corner_{lid[-1]}"]] = s * (s + 1) / 2
            rows.append(row)
            owners.append(INDEX[lid])
    return np.array(rows), owners


# (h, n) of control points in each helper point, and (h,) the control point each belongs to
MIXTURES, OWNERS = _mixtures()


def with_margins(points: NDArray[np.float64], regions: Regions, /) -> tuple[NDArray[np.float64], Regions]:
    """Return the control points (n, 3) followed by the helper points, and the regions for all of them."""
    fields = []
    for field in regions.fields:
        absent = [len(points) + i for i, owner in enumerate(OWNERS) if owner in field.left_out]
        fields.append(Field(field.weights, (*field.left_out, *absent)))
    return np.concatenate([points, MIXTURES @ points]), Regions(tuple(fields), regions.anchors)


def fold_margins(matrix: NDArray[np.float32], /) -> NDArray[np.float32]:
    """Return the (V, n) operator of the control points from that of control and helper points, (V, n + h)."""
    own, helpers = np.split(matrix, [CONTROL_POINT_COUNT], axis=1)
    folded: NDArray[np.float32] = own + helpers @ MIXTURES.astype(np.float32)
    return folded
