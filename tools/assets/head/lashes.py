"""Eyelashes: narrow sheets on the lid margins that follow the lids and rotate down when the eyes close."""

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from tools.assets.head.part import FRAMES, Part, grid

_MARGIN_RING = 3  # edge loop of the lid margin
_COLUMNS = 20
_CURL = np.radians([0.0, 14.0, 38.0])  # upward rotation of each row
_REACH = np.array([0.0, 0.45, 1.0])
# Length from the inner to the outer corner, cm.
_LENGTH = {"upper": (0.18, 0.44, 0.55, 0.62, 0.4), "lower": (0.08, 0.16, 0.2, 0.23, 0.15)}
_DIP = np.radians(62.0)  # downward rotation of the upper lashes at a full blink


def build_lashes(body: Part, eye_ring: NDArray[np.float64], blinks: dict[str, int], *, scale: float = 1.0) -> Part:
    """Build group "lashes".

    eye_ring : (V,) number of edges to the lid, of the body's vertices; blinks : side "l" or "r" -> blendshape index
    scale : of the length
    """
    pieces = [_sheet(body, eye_ring, side, row, blinks[side], scale) for side in "lr" for row in ("upper", "lower")]
    vertices = np.concatenate([p[0] for p in pieces])
    shapes = np.concatenate([p[1] for p in pieces], axis=1)
    uvs = np.concatenate([p[2] for p in pieces])
    size = len(_REACH) * _COLUMNS
    corners = np.concatenate([grid(len(_REACH), _COLUMNS) + i * size for i in range(len(pieces))])
    return Part(vertices, shapes, uvs, {"lashes": corners})


def _margin(body: Part, eye_ring: NDArray[np.float64], side: str, row: str) -> NDArray[np.int64]:
    """Return the vertices of one lid margin from the inner to the outer corner."""
    sign = 1.0 if side == "l" else -1.0
    x, y, _ = body.vertices.T
    loop = np.flatnonzero((eye_ring == _MARGIN_RING) & (x * sign > 0))
    loop = loop[np.argsort(x[loop] * sign)]
    inner, outer = loop[0], loop[-1]
    line = np.interp(x[loop] * sign, [x[inner] * sign, x[outer] * sign], [y[inner], y[outer]])
    chosen = y[loop] > line + 1e-6 if row == "upper" else y[loop] < line - 1e-6
    inside = loop[chosen]
    return np.concatenate([[inner], inside, [outer]])


def _sheet(
    body: Part, eye_ring: NDArray[np.float64], side: str, row: str, blink: int, scale: float
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    margin = _margin(body, eye_ring, side, row)
    sign = 1.0 if side == "l" else -1.0
    up = 1.0 if row == "upper" else -1.0
    weights = _resample(body.vertices[margin])
    roots = weights @ body.vertices[margin]
    shapes = np.einsum("cm,smk->sck", weights, body.shapes[:, margin])
    position = np.linspace(0, 1, _COLUMNS)
    length = np.interp(position, np.linspace(0, 1, 5), _LENGTH[row]) * scale
    fan = np.radians(np.interp(position, [0, 1], [-22.0, 38.0])) * sign
    rows, moved = [], []
    for reach, curl in zip(_REACH, _CURL, strict=True):
        direction = np.stack(
            [np.sin(fan) * np.cos(curl), np.full_like(fan, up * np.sin(curl)), np.cos(fan) * np.cos(curl)], axis=1
        )
        stick = direction * (reach * length)[:, None]
        rows.append(roots + stick + [0, up * 0.015, 0.015])
        offsets = shapes.copy()
        rotated = Rotation.from_euler("x", _DIP if row == "upper" else _DIP * 0.1).apply(stick)
        offsets[blink] += rotated - stick
        moved.append(offsets)
    u, v = np.meshgrid(position, _REACH)
    v = 0.5 + 0.5 * v if row == "upper" else 0.5 * v
    uvs = FRAMES["lashes"].map_into(np.stack([u.ravel(), v.ravel()], axis=1))
    return np.concatenate(rows), np.concatenate(moved, axis=1), uvs


def _resample(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return (columns, margin) weights of evenly spaced columns along the margin."""
    length = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    targets = np.linspace(0.04, 0.99, _COLUMNS) * length[-1]
    return np.stack([np.interp(targets, length, column) for column in np.eye(len(points))], axis=1)
