"""Hair that falls beside the face and down the neck, and hair that is tied in a knot."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tools.assets.head.locks import LOCK_KINDS, ShellHeight
from tools.assets.head.painting.noise import smoothstep
from tools.assets.head.part import FRAMES, Part, grid, join, rigid
from tools.assets.head.scalp import CENTRE, Scalp

_COLUMNS, _ROWS = 44, 10
_AXIS = np.array([0.0, 0.0, -6.0])  # of the neck, cm
_HALF_WIDTH, _DEPTH, _FORWARD = 10.3, 9.6, 7.4  # of the outline from above: at the sides, the back, the temples, cm
_REPEATS = 5  # of the texture around the head
_STRANDS = 46  # ribbons that hang over the sheet
_SPREAD = 2.6  # cm
_RAGGED = 0.03  # of the edge in front, radians


@dataclass(frozen=True)
class Fall:
    """Hair that hangs. bottom : height of its tips, cm; front : radians from the middle of the face to its edge

    wave : amplitude of waves, cm
    """

    bottom: float
    front: float = 0.95
    wave: float = 0.12


def build_fall(scalp: Scalp, fall: Fall, height: ShellHeight, random: np.random.Generator) -> Part:
    """Build the sheets of hair that hang, seen from inside and from outside, and the ribbons over them."""
    around = np.linspace(fall.front, 2 * np.pi - fall.front, _COLUMNS)
    ragged = random.uniform(-0.5, 0.4, _COLUMNS)
    outer = _surface(scalp, fall, height, around, ragged, 0.0)
    inner = _surface(scalp, fall, height, around, ragged, -0.5)
    column = np.abs((np.linspace(0, _REPEATS, _COLUMNS) + 1) % 2 - 1)  # mirrored, so that it has no seams
    u, v = np.meshgrid(column, np.linspace(1, 0, _ROWS))
    uvs = FRAMES["fall"].map_into(np.stack([u.ravel(), v.ravel()], axis=1))
    corners = grid(_ROWS, _COLUMNS)
    sheets = [
        Part(surface.reshape(-1, 3), rigid(surface.reshape(-1, 3)), uvs, {"hair": faces})
        for surface, faces in ((inner, corners[:, ::-1]), (outer, corners))
    ]
    return join([*sheets, *(_ribbon(scalp, fall, height, random) for _ in range(_STRANDS))])


def _surface(
    scalp: Scalp, fall: Fall, height: ShellHeight, around: NDArray[np.float64], ragged: NDArray[np.float64], lift: float
) -> NDArray[np.float64]:
    """Return (rows, columns, 3) points from the shell down. lift : distance outwards, cm"""
    position = np.full_like(around, 0.66)
    start = scalp.points(around, position * scalp.hairline(around), height(around, position) * 0.8)
    progress = np.linspace(0, 1, _ROWS)[:, None]
    y = start[:, 1] + (fall.bottom + ragged - start[:, 1]) * progress
    back = np.minimum(np.abs(around - fall.front), np.abs(2 * np.pi - fall.front - around))  # from the edge, radians
    taper = smoothstep(0.7, 0.0, back) * (0.3 * progress**2 + _RAGGED * np.sin(7 * y))
    around = around + np.sign(np.pi - around) * taper
    depth = np.where(np.cos(around) > 0, _FORWARD, _DEPTH)
    outline = np.hypot(np.sin(around) * _HALF_WIDTH, np.cos(around) * depth)
    own = np.hypot(start[:, 0] - _AXIS[0], start[:, 2] - _AXIS[2])
    heading = np.arctan2(start[:, 0] - _AXIS[0], start[:, 2] - _AXIS[2])
    heading = heading + (np.mod(around - heading + np.pi, 2 * np.pi) - np.pi) * smoothstep(0.0, 0.5, progress)
    radius = own + (outline - own) * smoothstep(0.0, 0.3, progress)
    radius = radius - 1.5 * smoothstep(0.6, 1.0, progress) * smoothstep(-6.0, -11.0, y)
    radius = radius + fall.wave * np.sin(around * 7 + y * 1.1) * progress + lift
    return np.stack([_AXIS[0] + radius * np.sin(heading), y, _AXIS[2] + radius * np.cos(heading)], axis=-1)


def _ribbon(scalp: Scalp, fall: Fall, height: ShellHeight, random: np.random.Generator) -> Part:
    """Return one ribbon over the sheet."""
    middle = random.uniform(fall.front - 0.03, 2 * np.pi - fall.front + 0.03)
    half = random.uniform(0.7, 1.3) * _SPREAD / 2 / _HALF_WIDTH
    around = middle + half * np.array([-1.0, 0.0, 1.0])
    surface = _surface(scalp, fall, height, around, np.full(3, random.uniform(-0.6, 0.9)), random.uniform(0.1, 0.4))
    surface[:, 1] += 0.12 * (surface[:, 1] - _AXIS) * [1, 0, 1] / _HALF_WIDTH
    u, v = np.meshgrid((random.integers(2) + np.array([0.03, 0.5, 0.97])) / LOCK_KINDS, np.linspace(0.95, 0, _ROWS))
    uvs = FRAMES["lock"].map_into(np.stack([u.ravel(), v.ravel()], axis=1))
    vertices = surface.reshape(-1, 3)
    return Part(vertices, rigid(vertices), uvs, {"hair": grid(_ROWS, 3)})


def build_bun(scalp: Scalp, radius: float, height: ShellHeight) -> Part:
    """Return a knot behind the crown. radius : cm"""
    columns, rows = 24, 9
    back = np.array([np.pi])
    root = scalp.points(back, np.array([0.42]), height(back, np.array([0.3])))[0]
    out = (root - CENTRE) / np.linalg.norm(root - CENTRE)
    centre = root + out * radius * 0.45
    side = np.array([1.0, 0.0, 0.0])
    forward = np.cross(side, out)
    polar, turn = np.meshgrid(np.linspace(0.03, 2.4, rows), np.arange(columns) * 2 * np.pi / columns, indexing="ij")
    bumps = 1 + 0.04 * np.sin(turn * 5 + polar * 4)
    ball = (
        out * (0.8 * np.cos(polar) * bumps)[..., None]
        + side * (np.sin(polar) * np.cos(turn) * bumps)[..., None]
        + forward * (np.sin(polar) * np.sin(turn) * bumps)[..., None]
    )
    vertices = (centre + radius * ball).reshape(-1, 3)
    u, v = np.meshgrid(np.abs((np.linspace(0, 4, columns + 1) + 1) % 2 - 1), np.linspace(1, 0.35, rows))
    uvs = FRAMES["fall"].map_into(np.stack([u.ravel(), v.ravel()], axis=1))
    return Part(vertices, rigid(vertices), uvs, {"hair": grid(rows, columns, closed="columns")[:, ::-1]})
