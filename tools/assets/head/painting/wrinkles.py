"""Where the skin of an old face has wrinkles and spots. Positions are those of the default head."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from tools.assets.head.painting.noise import layered, noise, smoothstep
from tools.assets.head.painting.texels import Texels

Points = Mapping[str, NDArray[np.float64]]
Floats = NDArray[np.float64]


def wrinkle_depth(texels: Texels, points: Points) -> Floats:
    """Return the (N,) depth of wrinkles, about 0 to 1: forehead, brow, crow's feet, below the eyes, cheeks, mouth."""
    x, y, z = texels.position.T.astype(float)
    side, front = np.abs(x), smoothstep(-3.0, 0.5, z)
    wander = noise(texels.position, 0.5)
    depth = _forehead(side, y, wander) + _brow(side, y, points)
    depth += _crows_feet(side, y, wander, points) + _bags(side, y, points)
    depth += _fold(side, y, points["nostril_border_l"], points["outer_lip_corner_l"], reach=1.1)
    depth += 0.8 * _marionette(side, y, points)
    depth += 0.5 * _lip_lines(texels, x, y, points)
    fine = 0.16 * np.clip(layered(texels.position * [1.0, 2.2, 1.0], 2.4, 3), 0, 1)
    return np.clip((depth + fine) * front, 0, 1)


def paint_spots(texels: Texels) -> Floats:
    """Return the (N,) strength of age spots, 0 to 1."""
    blotches = smoothstep(0.62, 0.8, noise(texels.position + 3.0, 1.7)) * smoothstep(
        3.0, 6.0, np.abs(texels.position[:, 0])
    )
    top = smoothstep(7.0, 9.5, texels.position[:, 1])
    return np.clip(blotches + top * smoothstep(0.6, 0.8, noise(texels.position, 1.5)), 0, 1)


def _line(distance: Floats, width: float) -> Floats:
    return np.asarray(np.exp(-((distance / width) ** 2)))


def _forehead(side: Floats, y: Floats, wander: Floats) -> Floats:
    lines = np.zeros_like(y)
    for height, strength in ((6.3, 0.6), (7.25, 0.9), (8.15, 0.7)):
        bend = y - height + 0.28 * (side / 3.0) ** 2 - 0.25 * wander
        lines += strength * _line(bend, 0.09) * smoothstep(4.4, 2.6, side + 0.6 * wander)
    return lines * 0.75


def _brow(side: Floats, y: Floats, points: Points) -> Floats:
    middle = points["brow_inner_l"][1]
    return 0.8 * _line(side - 0.42 - 0.1 * (y - middle), 0.08) * smoothstep(1.0, 0.3, np.abs(y - middle - 0.1))


def _crows_feet(side: Floats, y: Floats, wander: Floats, points: Points) -> Floats:
    corner = points["eye_outer_corner_l"]
    across, up = side - corner[0], y - corner[1]
    angle, radius = np.arctan2(up, across), np.hypot(across, up)
    lines = np.zeros_like(y)
    for at in (-0.62, -0.25, 0.12, 0.45):
        lines += _line((angle - at - 0.2 * wander) * radius, 0.075)
    return np.asarray(0.8 * lines * smoothstep(0.45, 0.8, radius) * smoothstep(2.3, 1.3, radius) * (across > 0))


def _bags(side: Floats, y: Floats, points: Points) -> Floats:
    lid = points["eyelid_lower_l"]
    shape = y - (lid[1] - 0.95 + 0.16 * (side - lid[0]) ** 2)
    upper = y - (lid[1] - 0.5 + 0.14 * (side - lid[0]) ** 2)
    within = smoothstep(1.7, 1.0, np.abs(side - lid[0]))
    return within * (0.75 * _line(shape, 0.12) + 0.4 * _line(upper, 0.08))


def _fold(side: Floats, y: Floats, start: Floats, end: Floats, *, reach: float) -> Floats:
    """The nasolabial fold: from the wing of the nose around the corner of the mouth."""
    top, bottom = start[1] + 0.3, end[1] - 0.5
    t = np.clip((top - y) / (top - bottom), 0, 1)
    path = start[0] + 0.15 + (end[0] + reach - start[0]) * (0.25 * t + 0.75 * t**1.2)
    return _line(side - path, 0.13) * smoothstep(top + 0.2, top - 0.5, y) * smoothstep(bottom - 0.5, bottom + 0.5, y)


def _marionette(side: Floats, y: Floats, points: Points) -> Floats:
    corner = points["outer_lip_corner_l"]
    path = corner[0] + 0.35 + 0.1 * (corner[1] - y)
    return (
        _line(side - path, 0.1)
        * smoothstep(corner[1] - 0.1, corner[1] - 0.6, y)
        * smoothstep(corner[1] - 2.6, corner[1] - 1.6, y)
    )


def _lip_lines(texels: Texels, x: Floats, y: Floats, points: Points) -> Floats:
    lip = points["outer_lip_upper_mid"][1]
    near = smoothstep(1.0, 0.3, np.abs(y - lip - 0.45)) * smoothstep(2.2, 1.4, np.abs(x))
    return near * smoothstep(0.35, 0.8, noise(texels.position, (3.4, 0.5, 0.5)))
