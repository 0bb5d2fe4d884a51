"""Locks of hair: curved ribbons along the scalp that rise out of the shell and descend at their tips."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tools.assets.head.part import FRAMES, Part, grid, rigid
from tools.assets.head.scalp import Scalp

LOCK_KINDS = 4
FLAT_KINDS = 2  # the first kinds are wide flat sheets of strands; the others are curls with a tip
_ROWS, _COLUMNS = 6, 3
_SINK = 0.6  # depth of a lock's root below the shell, relative to its height; flat locks are above the shell
_FLAT = 0.2  # cm
_BULGE = 0.16  # height of the middle of a lock above its edges, cm
_COVERED = 0.86  # position between crown (0) and hairline (1) up to which the shell is thickness

ShellHeight = Callable[[NDArray[np.float64], NDArray[np.float64]], NDArray[np.float64]]


@dataclass(frozen=True)
class Zone:
    """Locks of one part of the head.

    around, position : ranges of the roots: radians from the front, and 0 at the crown to 1 at the hairline
    length, width, height : cm, height above the shell; sweep : angle from straight down to the left, radians
    """

    count: int
    around: tuple[float, float]
    position: tuple[float, float]
    length: tuple[float, float]
    width: float
    height: float
    sweep: float


SHORT = (
    Zone(34, (-3.14, 3.14), (0.6, 0.76), (2.6, 3.8), 2.3, 0.1, 0.0),
    Zone(34, (-3.14, 3.14), (0.38, 0.58), (3.6, 4.8), 2.4, 0.16, 0.15),
    Zone(30, (-1.15, 1.15), (0.8, 0.9), (2.2, 3.6), 1.1, 0.5, 0.55),
    Zone(32, (-1.3, 1.3), (0.54, 0.76), (3.4, 5.2), 1.25, 0.65, 0.65),
    Zone(34, (-3.14, 3.14), (0.14, 0.42), (3.6, 5.4), 1.7, 0.4, 0.5),
)


def build_locks(
    scalp: Scalp, zones: Sequence[Zone], shell_height: ShellHeight, random: np.random.Generator
) -> list[Part]:
    """Build the locks of all zones, the lowest first.

    shell_height : thickness of the shell, cm, by radians around and position between crown and hairline
    """
    roots = []
    for zone in zones:
        spread = np.linspace(*zone.around, zone.count, endpoint=False)
        step = (zone.around[1] - zone.around[0]) / zone.count
        for around in spread + random.uniform(0, step, zone.count):
            roots.append((random.uniform(*zone.position), float(around), zone))
    roots.sort(key=lambda root: (root[2].height, -root[0]))
    parts = []
    for position, around, zone in roots:
        path = _path(scalp, zone, (around, position * float(scalp.hairline(np.array(around)))), random)
        positions = np.clip(path[:, 1] / scalp.hairline(path[:, 0]), 0, _COVERED)
        parts.append(_ribbon(scalp, zone, path, shell_height(path[:, 0], positions), random))
    return parts


def _path(scalp: Scalp, zone: Zone, root: tuple[float, float], random: np.random.Generator) -> NDArray[np.float64]:
    """Return the (rows, 2) directions, around and down, radians, of a lock from its root to its tip."""
    around, down = root
    length = random.uniform(*zone.length)
    heading = zone.sweep + random.normal(0, 0.22)
    curl = random.normal(0, 0.25)
    path = np.empty((_ROWS, 2))
    for i, progress in enumerate(np.linspace(0, 1, _ROWS)):
        path[i] = around, down
        stride = length / (_ROWS - 1) / float(scalp.radius_at(np.array([around]), np.array([down]))[0])
        angle = heading + curl * progress
        around += stride * np.sin(angle) / max(np.sin(down), 0.3)
        down += stride * np.cos(angle)
    return path


def _ribbon(
    scalp: Scalp, zone: Zone, path: NDArray[np.float64], thickness: NDArray[np.float64], random: np.random.Generator
) -> Part:
    """Return the lock along a path; thickness is that of the shell below it, (rows,) cm."""
    root = 0.2 if zone.height < _FLAT else -_SINK
    rise = zone.height * random.uniform(0.7, 1.25) * np.array([root, 0.55, 0.95, 1.0, 0.8, 0.35])
    spine = scalp.points(path[:, 0], path[:, 1], thickness + rise)
    out = scalp.points(path[:, 0], path[:, 1], thickness + rise + 1) - spine
    side = np.cross(out, np.gradient(spine, axis=0))
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    half = zone.width / 2 * random.uniform(0.8, 1.2) * np.array([0.75, 1.0, 1.05, 1.0, 0.85, 0.6])
    columns = np.linspace(-1, 1, _COLUMNS)
    lift = _BULGE * (1 - columns**2) + random.normal(0, 0.08) * columns
    vertices = spine[:, None] + side[:, None] * half[:, None, None] * columns[:, None] + out[:, None] * lift[:, None]
    kind = random.integers(FLAT_KINDS) if zone.height < _FLAT else random.integers(FLAT_KINDS, LOCK_KINDS)
    u, v = np.meshgrid((kind + (columns + 1) / 2 * 0.94 + 0.03) / LOCK_KINDS, np.linspace(1, 0, _ROWS))
    uvs = FRAMES["lock"].map_into(np.stack([u.ravel(), v.ravel()], axis=1))
    vertices = vertices.reshape(-1, 3)
    return Part(vertices, rigid(vertices), uvs, {"hair": grid(_ROWS, _COLUMNS)})
