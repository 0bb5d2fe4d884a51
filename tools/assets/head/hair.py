"""Hair: a shell over the scalp that becomes thinner at the hairline, locks that overlap on it, a fall or a knot.

The alpha of the atlas draws the strands. Faces are blended in the order of the file, so the lowest come first: what
falls, the shell, then the locks from the hairline up to the crown.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tools.assets.head.falling_hair import Fall, build_bun, build_fall
from tools.assets.head.locks import SHORT, ShellHeight, Zone, build_locks
from tools.assets.head.painting.noise import smoothstep
from tools.assets.head.parameters import HairParameters
from tools.assets.head.part import FRAMES, Part, grid, join, rigid
from tools.assets.head.scalp import Scalp

_AROUND, _ROWS = 56, 13


@dataclass(frozen=True)
class Style:
    """How hair is worn.

    top, side, front : thickness of the shell at the crown, at the sides, and what the forehead has more, cm
    zones : of the locks; fall : what hangs down, if any; bun : radius of a knot behind the crown, cm
    curl : 0 straight strands to 1 small curls
    """

    top: float
    side: float
    front: float = 0.0
    zones: Sequence[Zone] = ()
    fall: Fall | None = None
    bun: float = 0.0
    curl: float = 0.0


_FLAT_BACK = (Zone(30, (1.75, 4.5), (0.68, 0.82), (2.0, 3.0), 1.8, 0.06, 0.0),)
_LONG = (
    Zone(40, (-3.14, 3.14), (0.4, 0.7), (4.0, 5.6), 2.2, 0.12, 0.0),
    Zone(36, (-3.14, 3.14), (0.1, 0.4), (5.0, 7.0), 2.0, 0.18, 0.0),
)
_SWEPT = tuple(
    Zone(
        z.count,
        z.around,
        z.position,
        (z.length[0] * 1.15, z.length[1] * 1.15),
        z.width * 1.15,
        z.height * 0.85,
        -z.sweep,
    )
    for z in SHORT
)
_CROPPED = tuple(Zone(z.count, z.around, z.position, z.length, z.width, z.height * 0.35, z.sweep * 0.4) for z in SHORT)

STYLES: dict[str, Style | None] = {
    "bald": None,
    "short": Style(1.25, 0.42, 0.35, SHORT),
    "swept": Style(1.45, 0.5, 0.45, _SWEPT),
    "cropped": Style(0.6, 0.3, 0.1, _CROPPED),
    "fringe": Style(0.2, 0.25, 0.0, _FLAT_BACK),
    "buzz": Style(0.16, 0.12, curl=1.0),
    "afro": Style(2.6, 2.0, 0.2, curl=1.0),
    "bun": Style(0.75, 0.5, 0.1, bun=2.7),
    "curled_bun": Style(0.7, 0.45, 0.1, bun=3.3, curl=0.7),
    "bob": Style(1.1, 0.75, 0.15, _LONG, Fall(bottom=-9.5)),
    "long": Style(1.2, 0.8, 0.2, _LONG, Fall(bottom=-15.5, wave=0.35)),
}


def shell_height(style: Style, scale: float) -> ShellHeight:
    """Return the thickness of the hair, cm, as a function of radians around and position, 0 crown to 1 hairline."""

    def height(around: NDArray[np.float64], position: NDArray[np.float64]) -> NDArray[np.float64]:
        front = smoothstep(1.25, 0.7, np.abs(np.mod(around + np.pi, 2 * np.pi) - np.pi))
        top = style.top + style.front * front
        side = style.side + (style.top - style.side + 0.07) * front
        body = side + (top - side) * smoothstep(0.75, 0.3, position)
        return np.asarray(scale * body * smoothstep(1.02, 0.8 + 0.1 * front, position) + 0.03)

    return height


def build_hair(scalp: Scalp, hair: HairParameters) -> Part | None:
    """Build group "hair", None for a bald head."""
    style = STYLES[hair.style]
    if style is None:
        return None
    height = shell_height(style, hair.height)
    fall = [build_fall(scalp, style.fall, height, np.random.default_rng(hair.seed + 1))] if style.fall else []
    bun = [build_bun(scalp, style.bun, height)] if style.bun else []
    locks = build_locks(scalp, style.zones, height, np.random.default_rng(hair.seed))
    return join([*fall, _shell(scalp, height), *bun, *locks])


def _shell(scalp: Scalp, height: ShellHeight) -> Part:
    around = np.arange(_AROUND) * 2 * np.pi / _AROUND - np.pi
    position = np.linspace(0.02, 1.0, _ROWS) ** 0.9
    angles, positions = np.meshgrid(around, position)
    vertices = scalp.points(angles, positions * scalp.hairline(angles), height(angles, positions)).reshape(-1, 3)
    column, row = np.meshgrid(np.linspace(0, 1, _AROUND + 1), 1 - position)
    uvs = FRAMES["hair"].map_into(np.stack([column.ravel(), row.ravel()], axis=1))
    return Part(vertices, rigid(vertices), uvs, {"hair": grid(_ROWS, _AROUND, closed="columns")})
