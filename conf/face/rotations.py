"""Rotation vectors, rotation matrices and angles. A vector's direction is the axis, its length the angle in radians.

The formulas of a few numbers are evaluated with Python's floats: SciPy's class takes several times as long in
each frame, and to import it would delay the start of a call.
"""

import math

import numpy as np
from numpy.typing import NDArray

_SMALL = 1e-6  # rad, below which series replace quotients of sines; their error is of the fourth order


def rotation_matrix(vector: NDArray[np.floating], /) -> NDArray[np.float64]:
    """Return the (3, 3) matrix of a rotation vector (3,). Source: Rodrigues' rotation formula."""
    x, y, z = vector.tolist()
    squared = x * x + y * y + z * z
    angle = math.sqrt(squared)
    if angle < _SMALL:
        a, b = 1.0 - squared / 6.0, 0.5 - squared / 24.0
    else:
        a, b = math.sin(angle) / angle, 2.0 * (math.sin(angle / 2.0) / angle) ** 2
    c = 1.0 - b * squared
    return np.array(
        [
            [c + b * x * x, b * x * y - a * z, b * x * z + a * y],
            [b * x * y + a * z, c + b * y * y, b * y * z - a * x],
            [b * x * z - a * y, b * y * z + a * x, c + b * z * z],
        ]
    )


def rotation_vector(matrix: NDArray[np.floating], /) -> NDArray[np.float64]:
    """Return the rotation vector (3,) of a rotation matrix (3, 3); its length is at most pi.

    Source: Shepperd, "Quaternion from rotation matrix", 1978: the largest component is computed first.
    """
    (a, b, c), (d, e, f), (g, h, i) = matrix.tolist()
    candidates = (a + e + i, a, e, i)
    match candidates.index(max(candidates)):
        case 0:
            w, x, y, z = 1.0 + candidates[0], h - f, c - g, d - b
        case 1:
            w, x, y, z = h - f, 1.0 + a - e - i, b + d, c + g
        case 2:
            w, x, y, z = c - g, b + d, 1.0 + e - a - i, f + h
        case _:
            w, x, y, z = d - b, c + g, f + h, 1.0 + i - a - e
    if w < 0.0:
        w, x, y, z = -w, -x, -y, -z
    length = math.sqrt(x * x + y * y + z * z)  # sine of half the angle, in the unit of w, the cosine
    scale = 2.0 / w if length < _SMALL * w else 2.0 * math.atan2(length, w) / length
    return np.array([scale * x, scale * y, scale * z])


def yaw_pitch_roll(matrix: NDArray[np.floating], /) -> tuple[float, float, float]:
    """Return the angles, radians, of the rotations about y, x and z that a matrix (3, 3) consists of.

    The last is applied first. Looking straight up or down, where yaw and roll cannot be told apart, roll is 0.
    """
    (a, b, c), (d, e, f), (_, _, i) = matrix.tolist()
    pitch = math.asin(min(max(-f, -1.0), 1.0))
    if abs(f) > 1.0 - 1e-12:
        return math.atan2(b * -f, a), pitch, 0.0
    return math.atan2(c, i), pitch, math.atan2(d, e)
