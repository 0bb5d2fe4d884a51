"""Short hair: a shell over the scalp that thins out at the hairline, and locks that lie on it like shingles.

The atlas's alpha makes strands of both. They are drawn blended in the order of the file, so what lies lower comes first:
the shell, then the locks from the hairline up to the crown.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tools.head.noise import smoothstep
from tools.head.part import FRAMES, Part, grid, rigid
from tools.head.scalp import Scalp, hairline

LOCK_KINDS = 4
FLAT_KINDS = 2  # the first of them: wide sheets of strands that lie close; the others are curls with a tip
_AROUND, _ROWS = 56, 13
_LOCK_ROWS, _LOCK_COLUMNS = 6, 3


@dataclass(frozen=True)
class Zone:
    """Locks of one part of the head.

    around, share : ranges of where they grow: radians from the front, share of the way from crown to hairline
    length, width, height : cm; height over the shell; sweep : radians off the way straight down, to the left
    """

    count: int
    around: tuple[float, float]
    share: tuple[float, float]
    length: tuple[float, float]
    width: float
    height: float
    sweep: float


_ZONES = (
    Zone(34, (-3.14, 3.14), (0.6, 0.76), (2.6, 3.8), 2.3, 0.1, 0.0),
    Zone(34, (-3.14, 3.14), (0.38, 0.58), (3.6, 4.8), 2.4, 0.16, 0.15),
    Zone(26, (-1.2, 1.2), (0.8, 0.9), (2.2, 3.4), 1.15, 0.5, 0.5),
    Zone(32, (-1.4, 1.4), (0.54, 0.76), (3.2, 4.8), 1.3, 0.65, 0.6),
    Zone(34, (-3.14, 3.14), (0.08, 0.4), (3.4, 5.0), 1.7, 0.45, 0.5),
)
_SINK = 0.6  # share of its height that a lock's root lies under the shell; flat locks lie wholly above it
_FLAT = 0.2  # cm


def shell_height(around: NDArray[np.float64], share: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return how thick the hair lies, cm; share runs from 0 at the crown to 1 at the hairline."""
    front = smoothstep(1.25, 0.7, np.abs(around))
    top = 1.25 + 0.35 * front
    side = 0.42 + 0.9 * front
    body = side + (top - side) * smoothstep(0.75, 0.3, share)
    return np.asarray(body * smoothstep(1.02, 0.8 + 0.1 * front, share) + 0.03)


def build_hair(scalp: Scalp) -> Part:
    """Build group "hair"."""
    parts = [_shell(scalp), *_locks(scalp, np.random.default_rng(7))]
    vertices = np.concatenate([p[0] for p in parts])
    uvs = np.concatenate([p[1] for p in parts])
    corners, vertex, uv = [], 0, 0
    for points, places, faces in parts:
        corners.append(faces + [vertex, uv])
        vertex, uv = vertex + len(points), uv + len(places)
    return Part(vertices, rigid(vertices), uvs, {"hair": np.concatenate(corners)})


_Strip = tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.int64]]


def _shell(scalp: Scalp) -> _Strip:
    around = np.arange(_AROUND) * 2 * np.pi / _AROUND - np.pi
    share = np.linspace(0.02, 1.0, _ROWS) ** 0.9
    turn, part = np.meshgrid(around, share)
    vertices = scalp.points(turn, part * hairline(turn), shell_height(turn, part)).reshape(-1, 3)
    column, row = np.meshgrid(np.linspace(0, 1, _AROUND + 1), 1 - share)
    uvs = FRAMES["hair"].place(np.stack([column.ravel(), row.ravel()], axis=1))
    return vertices, uvs, grid(_ROWS, _AROUND, closed="columns")


def _locks(scalp: Scalp, random: np.random.Generator) -> list[_Strip]:
    roots = []
    for zone in _ZONES:
        spread = np.linspace(*zone.around, zone.count, endpoint=False)
        step = (zone.around[1] - zone.around[0]) / zone.count
        for around in spread + random.uniform(0, step, zone.count):
            roots.append((random.uniform(*zone.share), around, zone))
    roots.sort(key=lambda root: (root[2].height, -root[0]))
    return [_lock(scalp, root, random) for root in roots]


def _lock(scalp: Scalp, root: tuple[float, float, Zone], random: np.random.Generator) -> _Strip:
    share, around, zone = root
    down = share * float(hairline(np.array(around)))
    length = random.uniform(*zone.length)
    heading = zone.sweep + random.normal(0, 0.22)
    curl = random.normal(0, 0.25)
    steps = np.linspace(0, 1, _LOCK_ROWS)
    path = np.empty((_LOCK_ROWS, 2))
    for i in range(_LOCK_ROWS):
        path[i] = around, down
        stride = length / (_LOCK_ROWS - 1) / float(scalp.out(np.array([around]), np.array([down]))[0])
        angle = heading + curl * steps[i]
        around += stride * np.sin(angle) / max(np.sin(down), 0.15)
        down += stride * np.cos(angle)
    thick = shell_height(path[:, 0], np.clip(path[:, 1] / hairline(path[:, 0]), 0, 0.86))
    rise = zone.height * random.uniform(0.7, 1.25)
    root = 0.2 if zone.height < _FLAT else -_SINK
    height = thick + rise * np.array([root, 0.55, 0.95, 1.0, 0.8, 0.35])
    spine = scalp.points(path[:, 0], path[:, 1], height)
    along = np.gradient(spine, axis=0)
    out = scalp.points(path[:, 0], path[:, 1], height + 1) - spine
    side = np.cross(out, along)
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    half = zone.width / 2 * random.uniform(0.8, 1.2) * np.array([0.75, 1.0, 1.05, 1.0, 0.85, 0.6])
    tilt = random.normal(0, 0.25)
    columns = np.linspace(-1, 1, _LOCK_COLUMNS)
    bulge = 0.16 * (1 - columns**2)
    vertices = (
        spine[:, None]
        + side[:, None] * half[:, None, None] * columns[:, None]
        + out[:, None] * (bulge + tilt * 0.3 * columns)[:, None]
    )
    kind = random.integers(FLAT_KINDS) if zone.height < _FLAT else random.integers(FLAT_KINDS, LOCK_KINDS)
    u, v = np.meshgrid((kind + (columns + 1) / 2 * 0.94 + 0.03) / LOCK_KINDS, 1 - steps)
    uvs = FRAMES["lock"].place(np.stack([u.ravel(), v.ravel()], axis=1))
    return vertices.reshape(-1, 3), uvs, grid(_LOCK_ROWS, _LOCK_COLUMNS)
