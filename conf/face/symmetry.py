"""Left and right of a face: the mirror image of a motion, and the part of it that belongs to one side."""

import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_INDEX, CONTROL_POINTS

OTHER_SIDE = {"l": "r", "r": "l"}


def mirror_motion(displacements: NDArray[np.float32], /) -> NDArray[np.float32]:
    """Return the mirror image of displacements, (..., n, 3) along face axes."""
    return displacements[..., MIRROR_INDICES, :] * np.array([-1, 1, 1], np.float32)


def side_weighted(displacements: NDArray[np.float32], side: str, /) -> NDArray[np.float32]:
    """Return (..., n, 3) displacements of one side, "l" or "r" of the subject, with half of those in the middle."""
    return displacements * SIDE_WEIGHTS[side][:, None]


def _mirror_name(name: str) -> str:
    stem, _, side = name.rpartition("_")
    return f"{stem}_{OTHER_SIDE[side]}" if side in OTHER_SIDE else name


def _side_weights(side: str) -> NDArray[np.float32]:
    weights = {side: 1.0, OTHER_SIDE[side]: 0.0}
    return np.array([weights.get(point.name.rpartition("_")[2], 0.5) for point in CONTROL_POINTS], np.float32)


# (n,) index of the control point on the other side; of itself in the middle
MIRROR_INDICES = [CONTROL_POINT_INDEX[_mirror_name(point.name)] for point in CONTROL_POINTS]
SIDE_WEIGHTS = {side: _side_weights(side) for side in OTHER_SIDE}  # (n,) 1 on the side, 0.5 in the middle
