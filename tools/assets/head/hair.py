"""Short hair: a shell over the scalp that thins out at the hairline, and locks that lie on it like shingles.

The atlas's alpha makes strands of both. They are drawn blended in the order of the file, so what lies lower comes
first: the shell, then the locks from the hairline up to the crown.
"""

import numpy as np
from numpy.typing import NDArray

from tools.assets.head.locks import build_locks
from tools.assets.head.noise import smoothstep
from tools.assets.head.part import FRAMES, Part, grid, join, rigid
from tools.assets.head.scalp import Scalp, hairline

_AROUND, _ROWS = 56, 13


def shell_height(around: NDArray[np.float64], share: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return how thick the hair lies, cm; share runs from 0 at the crown to 1 at the hairline."""
    front = smoothstep(1.25, 0.7, np.abs(around))
    top = 1.25 + 0.35 * front
    side = 0.42 + 0.9 * front
    body = side + (top - side) * smoothstep(0.75, 0.3, share)
    return np.asarray(body * smoothstep(1.02, 0.8 + 0.1 * front, share) + 0.03)


def build_hair(scalp: Scalp) -> Part:
    """Build group "hair"."""
    return join([_shell(scalp), *build_locks(scalp, shell_height, np.random.default_rng(7))])


def _shell(scalp: Scalp) -> Part:
    around = np.arange(_AROUND) * 2 * np.pi / _AROUND - np.pi
    share = np.linspace(0.02, 1.0, _ROWS) ** 0.9
    turn, part = np.meshgrid(around, share)
    vertices = scalp.points(turn, part * hairline(turn), shell_height(turn, part)).reshape(-1, 3)
    column, row = np.meshgrid(np.linspace(0, 1, _AROUND + 1), 1 - share)
    uvs = FRAMES["hair"].place(np.stack([column.ravel(), row.ravel()], axis=1))
    return Part(vertices, rigid(vertices), uvs, {"hair": grid(_ROWS, _AROUND, closed="columns")})
