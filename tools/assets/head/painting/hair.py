"""Paint hair: strands along the direction of growth, with alpha so that each strand has its own end."""

import numpy as np
from numpy.typing import NDArray

from tools.assets.head.hair import STYLES
from tools.assets.head.locks import FLAT_KINDS, LOCK_KINDS
from tools.assets.head.painting.noise import noise, smoothstep
from tools.assets.head.painting.texels import Texels
from tools.assets.head.parameters import HairParameters, HeadParameters
from tools.assets.head.part import FRAMES, Frame
from tools.assets.head.scalp import find_hairline

_SKULL = 9.0  # cm, radius of the skull
_KNOT_SHADE = 0.45  # brightness of the deepest hair of a knot, relative


def paint_hair(texels: Texels, head: HeadParameters) -> NDArray[np.float64]:
    """Return (N, 4) sRGB colours and alpha, 0 to 255, of shell, locks and what falls."""
    lock, fall = (_is_in(FRAMES[name], texels)[:, None] for name in ("lock", "fall"))
    painted = np.where(lock, _locks(texels, head.hair), _shell(texels, head.hair))
    return np.where(fall, _fall(texels, head.hair), painted)


def _is_in(frame: Frame, texels: Texels) -> NDArray[np.bool_]:
    margin = 0.002
    low = np.array([frame.left, frame.bottom]) - margin
    high = low + np.array([frame.width, frame.height]) + 2 * margin
    return np.asarray(((texels.uv >= low) & (texels.uv <= high)).all(axis=1))


def coverage(around: NDArray[np.float64], position: NDArray[np.float64], hair: HairParameters) -> NDArray[np.float64]:
    """Return the (N,) fraction of hair that a balding head has left, 0 to 1.

    around : radians from the front; position : 0 at the crown to 1 at the hairline
    """
    if not hair.crown:
        return np.ones_like(position)
    edge = hair.crown + (1.15 - hair.crown) * smoothstep(1.4, 0.95, np.abs(around))
    return smoothstep(edge - 0.06, edge + 0.16, position)


def strands(across: NDArray[np.float64], along: NDArray[np.float64], *, density: float) -> NDArray[np.float64]:
    """Return (N,) about -1 to 1: fine, slightly irregular lines along the second coordinate, in clumps."""
    wander = noise(np.stack([across * density * 0.08, along * 1.5, 0 * along], axis=1), 1.0)
    lines = [
        noise(np.stack([across * density * scale + wander, along * run, 0 * along + 5 * scale], axis=1), 1.0)
        for scale, run in ((1.0, 0.9), (0.45, 0.7), (0.16, 0.5))
    ]
    return np.asarray(0.6 * lines[0] + 0.45 * lines[1] + 0.2 * lines[2])


def curls(points: NDArray[np.floating]) -> NDArray[np.float64]:
    """Return (N,) about -1 to 1: small curls. points : (N, 3) cm"""
    bent = np.asarray(points, float) + 0.35 * np.stack([noise(points + i * 9.0, 1.6) for i in range(3)], axis=1)
    rings = np.sin(9.0 * noise(bent, 2.2) + 5.0 * noise(bent + 3.0, 4.5))
    return np.asarray(0.65 * rings + 0.5 * noise(points, 9.0))


def tint(value: NDArray[np.floating], hair: HairParameters) -> NDArray[np.float64]:
    """Return the (N, 3) hair colour of values from -1 (dark) to 1 (light)."""
    value = np.clip(value, -1, 1)[:, None]
    dark, middle, light = (np.array(c, float) for c in (hair.dark, hair.middle, hair.light))
    return np.asarray(np.where(value < 0, middle + (middle - dark) * value, middle + (light - middle) * value))


def _fall(texels: Texels, hair: HairParameters) -> NDArray[np.float64]:
    frame = FRAMES["fall"]
    across, up = ((texels.uv - [frame.left, frame.bottom]) / [frame.width, frame.height]).T
    position = 1 - up
    lines = strands(across + 1.0, position * 3, density=70.0)
    curl = _curl(hair)
    if curl:
        lines = lines * (1 - curl) + curl * curls(texels.position)
    style = STYLES[hair.style]
    deepest = hair.shade if style and style.fall else _KNOT_SHADE
    shade = deepest + (1 - deepest) * np.clip(texels.sky, 0, 1)
    colours = tint(lines * 0.85 - 0.15, hair) * shade[:, None]
    ends = 0.9 + 0.09 * strands(across + 5.0, np.zeros_like(position), density=60.0)
    alpha = smoothstep(ends + 0.04, ends - 0.06, position)
    return np.concatenate([colours, 255 * alpha[:, None]], axis=1)


def _curl(hair: HairParameters) -> float:
    style = STYLES[hair.style]
    return style.curl if style else 0.0


def _shell(texels: Texels, hair: HairParameters) -> NDArray[np.float64]:
    frame = FRAMES["hair"]
    across, up = ((texels.uv - [frame.left, frame.bottom]) / [frame.width, frame.height]).T
    position = 1 - up
    lines = strands(across, position * 5, density=300.0)
    reach = strands(across + 3.0, position * 0.5, density=420.0)
    curl = _curl(hair)
    if curl:
        small = curls(texels.position)
        lines, reach = lines * (1 - curl) + curl * small, reach * (1 - curl) + curl * small
    shade = hair.shade + (1 - hair.shade) * np.clip(texels.sky, 0, 1)
    colours = tint(lines * 0.8 - 0.3, hair) * shade[:, None]
    around = (across - 0.5) * 2 * np.pi
    hairline = find_hairline(hair.hairline, hair.receding)
    depth = (1 - position) * hairline(around) * _SKULL  # cm inside the hairline
    alpha = smoothstep(0.05, 0.75, depth + 0.45 * reach)
    alpha = alpha * coverage(around, position + 0.04 * reach, hair)
    return np.concatenate([colours, 255 * alpha[:, None]], axis=1)


def _locks(texels: Texels, hair: HairParameters) -> NDArray[np.float64]:
    frame = FRAMES["lock"]
    across, up = ((texels.uv - [frame.left, frame.bottom]) / [frame.width, frame.height]).T
    position = 1 - up
    kind = np.floor(across * LOCK_KINDS)
    flat = kind < FLAT_KINDS
    inside = across * LOCK_KINDS - kind
    middle = 0.5 + np.where(flat, 0.0, 0.1 * np.sin(kind * 2.4) * position)
    squeezed = 0.5 + (inside - middle) / (1 - np.where(flat, 0.0, 0.3) * position**2)
    lines = np.where(
        flat,
        strands(squeezed + kind * 3, position * 1.5, density=46.0),
        strands(squeezed + kind * 3, position * 1.2, density=30.0),
    )
    edge = np.abs(squeezed - 0.5) * 2
    length = noise(
        np.stack([squeezed * np.where(flat, 40, 13) + kind * 57, 0 * position, 0 * position + 2], axis=1), 1.0
    )
    slope = np.where(flat, 0.12, 0.55)
    colours = tint(lines * 1.0 - 0.3 + slope * (position - 0.3) - np.where(flat, 0.05, 0.25) * edge**2, hair)
    limit = np.where(flat, 0.72, 0.8) + 0.3 * lines
    alpha = smoothstep(limit + 0.12, limit - 0.12, edge) * smoothstep(0.02, 0.3, position + 0.12 * lines)
    end = np.where(flat, 0.7 + 0.32 * length, 0.72 + 0.3 * length) - 0.3 * edge**2
    alpha = alpha * smoothstep(end + 0.06, end - 0.12, position)
    return np.concatenate([colours, 255 * alpha[:, None]], axis=1)
