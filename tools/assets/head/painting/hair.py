"""Paint hair: strands along the direction of growth, with alpha so that each strand has its own end."""

import numpy as np
from numpy.typing import NDArray

from tools.assets.head.locks import FLAT_KINDS, LOCK_KINDS
from tools.assets.head.painting.noise import noise, smoothstep
from tools.assets.head.painting.texels import Texels
from tools.assets.head.part import FRAMES
from tools.assets.head.scalp import hairline

DARK = np.array([34.0, 24, 19])
MIDDLE = np.array([66.0, 46, 34])
LIGHT = np.array([110.0, 80, 56])
_SKULL = 9.0  # cm, radius of the skull


def paint_hair(texels: Texels) -> NDArray[np.float64]:
    """Return (N, 4) sRGB colours and alpha, 0 to 255, of shell and locks."""
    frame = FRAMES["lock"]
    lock = (texels.uv[:, 0] > frame.left) & (texels.uv[:, 1] > frame.bottom)
    return np.where(lock[:, None], _locks(texels), _shell(texels))


def strands(across: NDArray[np.float64], along: NDArray[np.float64], *, density: float) -> NDArray[np.float32]:
    """Return (N,) about -1 to 1: fine, slightly irregular lines along the second coordinate, in clumps."""
    wander = noise(np.stack([across * density * 0.08, along * 1.5, 0 * along], axis=1), 1.0)
    lines = [
        noise(np.stack([across * density * scale + wander, along * run, 0 * along + 5 * scale], axis=1), 1.0)
        for scale, run in ((1.0, 0.9), (0.45, 0.7), (0.16, 0.5))
    ]
    return np.asarray(0.6 * lines[0] + 0.45 * lines[1] + 0.2 * lines[2])


def tint(value: NDArray[np.floating]) -> NDArray[np.float64]:
    """Return the (N, 3) hair colour of values from -1 (dark) to 1 (light)."""
    value = np.clip(value, -1, 1)[:, None]
    return np.asarray(np.where(value < 0, MIDDLE + (MIDDLE - DARK) * value, MIDDLE + (LIGHT - MIDDLE) * value))


def _shell(texels: Texels) -> NDArray[np.float64]:
    frame = FRAMES["hair"]
    across, up = ((texels.uv - [frame.left, frame.bottom]) / [frame.width, frame.height]).T
    position = 1 - up
    lines = strands(across, position * 5, density=300.0)
    shade = 0.3 + 0.7 * np.clip(texels.sky, 0, 1)
    colours = tint(lines * 0.8 - 0.3) * shade[:, None]
    around = (across - 0.5) * 2 * np.pi
    depth = (1 - position) * hairline(around) * _SKULL  # cm inside the hairline
    reach = strands(across + 3.0, position * 0.5, density=420.0)
    alpha = smoothstep(0.05, 0.75, depth + 0.45 * reach)
    return np.concatenate([colours, 255 * alpha[:, None]], axis=1)


def _locks(texels: Texels) -> NDArray[np.float64]:
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
    colours = tint(lines * 1.0 - 0.3 + slope * (position - 0.3) - np.where(flat, 0.05, 0.25) * edge**2)
    limit = np.where(flat, 0.72, 0.8) + 0.3 * lines
    alpha = smoothstep(limit + 0.12, limit - 0.12, edge) * smoothstep(0.02, 0.3, position + 0.12 * lines)
    end = np.where(flat, 0.7 + 0.32 * length, 0.72 + 0.3 * length) - 0.3 * edge**2
    alpha = alpha * smoothstep(end + 0.06, end - 0.12, position)
    return np.concatenate([colours, 255 * alpha[:, None]], axis=1)
