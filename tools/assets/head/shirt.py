"""A crew-neck shirt: a smooth shell around chest and shoulders, a height field in polar coordinates inside the chest.

Every ray from there above the horizontal has one last intersection with the body, so the shell is a grid: around the
body, and from the collar down to a level rim below most images. The arms are cut off at its sides.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter, gaussian_filter1d

from tools.assets.head.character import Character
from tools.assets.head.part import FRAMES, Part, grid, rigid
from tools.assets.head.raycast import distances_along

_CHEST = np.array([0.0, -34.0, -8.0])  # cm
_AROUND = 48
_HALF_WIDTH = 20.5  # of the shoulders, cm
# Angle of the collar's edge from straight up, seen from the chest, degrees.
_COLLAR = {"front": 18.2, "side": 20.2, "back": 15.6}
# Rows from the collar down: degrees below the collar's edge, distance from the skin in cm.
_COLLAR_ROWS = ((-0.5, -0.35), (-0.1, 0.10), (0.1, 0.34), (0.5, 0.46), (2.6, 0.55), (3.3, 0.52), (3.7, 0.38))
_BODY_ROWS = 11


def collar_angle(around: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the collar's edge in radians from straight up; around is 0 at the front, pi at the back."""
    level = np.where(np.cos(around) > 0, _COLLAR["front"], _COLLAR["back"])
    weight = np.cos(around) ** 2
    return np.asarray(np.radians(level * weight + _COLLAR["side"] * (1 - weight)))


def angle_below_collar(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the angle of (N, 3) points below the collar's edge, seen from the chest, degrees."""
    x, y, z = (points - _CHEST).T
    return np.asarray(np.degrees(np.arctan2(np.hypot(x, z), y) - collar_angle(np.arctan2(x, z))))


def build_shirt(character: Character) -> Part:
    """Build the shirt as group "shirt"."""
    around = np.arange(_AROUND) * 2 * np.pi / _AROUND - np.pi
    angles, offsets = _rows(around)
    directions = np.stack([np.sin(angles) * np.sin(around), np.cos(angles), np.sin(angles) * np.cos(around)], axis=-1)
    radius = _radius(character, directions)
    surface = _CHEST + directions * radius[..., None]
    vertices = surface + _outward(surface) * offsets[:, None, None]
    rows = len(offsets)
    column, row = np.meshgrid(np.linspace(0, 1, _AROUND + 1), 1 - _row_positions(rows))
    uvs = FRAMES["shirt"].map_into(np.stack([column.ravel(), row.ravel()], axis=1))
    vertices = vertices.reshape(-1, 3)
    return Part(vertices, rigid(vertices), uvs, {"shirt": grid(rows, _AROUND, closed="columns")})


def _row_positions(rows: int) -> NDArray[np.float64]:
    collar = len(_COLLAR_ROWS)
    return np.concatenate([np.linspace(0, 0.3, collar), np.linspace(0.3, 1, rows - collar + 1)[1:]])


def _rows(around: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the (rows, around) angles from straight up, radians, and the (rows,) distances from the skin, cm."""
    edge = collar_angle(around)
    below = np.radians([degrees for degrees, _ in _COLLAR_ROWS])
    start = edge + below[-1]
    progress = (np.arange(1, _BODY_ROWS + 1) / _BODY_ROWS)[:, None] ** 1.15
    angles = np.concatenate([edge + below[:, None], start + (np.pi / 2 - start) * progress])
    return angles, np.concatenate([[off for _, off in _COLLAR_ROWS], np.full(_BODY_ROWS, 0.45)])


def _radius(character: Character, directions: NDArray[np.float64]) -> NDArray[np.float64]:
    body = character.base.faces[character.base.groups == "body"]
    centre = character.vertices[body].mean(axis=1)
    body = body[(centre[:, 1] > -45) & (centre[:, 1] < np.where(centre[:, 2] > -6, -11.5, -9.0))]
    triangles = np.concatenate([body[:, [0, 1, 2]], body[:, [0, 2, 3]]])
    hits = distances_along(_CHEST, directions.reshape(-1, 3), character.vertices, triangles, farthest=True)
    radius = hits.reshape(directions.shape[:2])
    side = _HALF_WIDTH / np.maximum(np.abs(directions[..., 0]), 1e-3)
    radius = -np.logaddexp(-radius * 1.2, -side * 1.2) / 1.2
    collar = len(_COLLAR_ROWS)
    smooth = gaussian_filter(radius, (1.0, 1.4), mode=("nearest", "wrap"))
    fade = np.clip((np.arange(len(radius)) - collar + 1) / 3, 0, 1)[:, None]
    radius = gaussian_filter1d(radius, 0.8, axis=1, mode="wrap")
    return np.asarray(radius * (1 - fade) + smooth * fade)


def _outward(surface: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return unit normals of the (rows, around, 3) grid."""
    down = np.gradient(surface, axis=0)
    across = np.roll(surface, -1, axis=1) - np.roll(surface, 1, axis=1)
    normal = np.cross(down, across)
    return np.asarray(normal / np.linalg.norm(normal, axis=-1, keepdims=True))
