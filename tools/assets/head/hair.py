"""Short hair: a shell over the scalp that becomes thinner at the hairline, and locks that overlap on it.

The alpha of the atlas draws the strands. Faces are blended in the order of the file, so the lowest come first: the
shell, then the locks from the hairline up to the crown.
"""

import numpy as np
from numpy.typing import NDArray

from tools.assets.head.locks import build_locks
from tools.assets.head.painting.noise import smoothstep
from tools.assets.head.part import FRAMES, Part, grid, join, rigid
from tools.assets.head.scalp import Scalp, hairline

_AROUND, _ROWS = 56, 13


def shell_height(around: NDArray[np.float64], position: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the thickness of the hair, cm; position runs from 0 at the crown to 1 at the hairline."""
    front = smoothstep(1.25, 0.7, np.abs(around))
    top = 1.25 + 0.35 * front
    side = 0.42 + 0.9 * front
    body = side + (top - side) * smoothstep(0.75, 0.3, position)
    return np.asarray(body * smoothstep(1.02, 0.8 + 0.1 * front, position) + 0.03)


def build_hair(scalp: Scalp) -> Part:
    """Build group "hair"."""
    return join([_shell(scalp), *build_locks(scalp, shell_height, np.random.default_rng(7))])


def _shell(scalp: Scalp) -> Part:
    around = np.arange(_AROUND) * 2 * np.pi / _AROUND - np.pi
    position = np.linspace(0.02, 1.0, _ROWS) ** 0.9
    angles, positions = np.meshgrid(around, position)
    heights = shell_height(angles, positions)
    vertices = scalp.points(angles, positions * hairline(angles), heights).reshape(-1, 3)
    column, row = np.meshgrid(np.linspace(0, 1, _AROUND + 1), 1 - position)
    uvs = FRAMES["hair"].map_into(np.stack([column.ravel(), row.ravel()], axis=1))
    return Part(vertices, rigid(vertices), uvs, {"hair": grid(_ROWS, _AROUND, closed="columns")})
