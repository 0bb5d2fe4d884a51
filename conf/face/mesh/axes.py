"""Rotate a mesh with any up and front axes to y up and z towards the viewer."""

import numpy as np
from numpy.typing import NDArray

AXES = {
    f"{sign}{letter}": value * np.eye(3)[index]
    for index, letter in enumerate("xyz")
    for sign, value in (("", 1.0), ("-", -1.0))
}

# All 24 pairs (up, front), the usual ones first.
ORIENTATIONS = [
    *(("y", "z"), ("z", "-y"), ("z", "y"), ("y", "-z"), ("z", "x"), ("z", "-x"), ("y", "x"), ("y", "-x")),
    *((up, front) for up in ("x", "-x", "-y", "-z") for front in AXES if up[-1] != front[-1]),
]


def axes_rotation(up: str, front: str, /) -> NDArray[np.float64]:
    """Return the (3, 3) rotation from a mesh's axes to face axes: x to the subject's left, y up, z to the viewer.

    up, front : the mesh's axis towards the crown and towards the nose, one of x, y, z, -x, -y, -z
    Raises ValueError if an axis is none of these, or both lie on one line.
    """
    for name, axis in (("up", up), ("front", front)):
        if axis not in AXES:
            raise ValueError(f"{name} must be one of {', '.join(AXES)}, got {axis!r}")
    if up[-1] == front[-1]:
        raise ValueError(f"front must not lie on the same line as up, got up {up!r} and front {front!r}")
    return np.stack([np.cross(AXES[up], AXES[front]), AXES[up], AXES[front]])
