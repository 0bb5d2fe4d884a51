"""The eyeballs: caps of a sphere with a corneal bulge, looking straight ahead."""

import numpy as np
from numpy.typing import NDArray

from tools.assets.head.part import FRAMES, Part, grid, rigid

IRIS_ANGLE = 0.365  # radians from the optical axis to the limbus
CAP_ANGLE = 1.75  # of the cap's rim from the optical axis, radians
_BULGE = 0.05  # height of the cornea, cm
_COLUMNS = 28
_RINGS = np.array([0.02, 0.08, 0.14, 0.2, 0.26, 0.32, 0.365, 0.41, 0.5, 0.62, 0.78, 0.96, 1.16, 1.4, CAP_ANGLE])


def eye_uv(angle: NDArray[np.float64], around: NDArray[np.float64]) -> NDArray[np.float64]:
    """Map polar coordinates on the eyeball to the unit square, with more area for the iris."""
    radius = 0.5 * np.sqrt(angle / CAP_ANGLE)
    return np.stack([0.5 + radius * np.cos(around), 0.5 + radius * np.sin(around)], axis=-1)


def build_eyeball(group: str, centre: NDArray[np.float64], radius: float) -> Part:
    """Build one eyeball; its first vertex is the front of the cornea."""
    angle, around = np.meshgrid(_RINGS, np.arange(_COLUMNS) * 2 * np.pi / _COLUMNS, indexing="ij")
    angle, around = angle.ravel(), around.ravel()
    front = np.array([[0.0, 0.0, 1.0]])
    direction = np.stack([np.sin(angle) * np.cos(around), np.sin(angle) * np.sin(around), np.cos(angle)], axis=1)
    polar = np.concatenate([[0.0], angle])
    bulge = _BULGE * np.clip(1 - (polar / (1.25 * IRIS_ANGLE)) ** 2, 0, None)
    vertices = centre + np.concatenate([front, direction]) * (radius + bulge)[:, None]
    uvs = FRAMES["eye"].map_into(eye_uv(polar, np.concatenate([[0.0], around])))
    rings = grid(len(_RINGS), _COLUMNS, closed="columns")
    rings = np.stack([rings[..., 0], rings[..., 0]], axis=-1) + 1
    column = np.arange(_COLUMNS)
    fan = np.stack([np.zeros_like(column), 1 + column, 1 + (column + 1) % _COLUMNS, np.full_like(column, -1)], axis=1)
    return Part(vertices, rigid(vertices), uvs, {group: np.concatenate([np.stack([fan, fan], axis=-1), rings])})
