"""Paint hair: strands along the way it grows, with the alpha that lets them end one by one."""

import numpy as np
from numpy.typing import NDArray

from tools.head.hair import LOCK_KINDS
from tools.head.noise import noise, smoothstep
from tools.head.part import FRAMES
from tools.head.texels import Texels

DARK = np.array([34.0, 24, 19])
MIDDLE = np.array([72.0, 51, 38])
LIGHT = np.array([112.0, 82, 58])


def paint_hair(texels: Texels) -> NDArray[np.float64]:
    """Return (N, 4) sRGB colours and alpha, 0 to 255, of shell and locks."""
    frame = FRAMES["lock"]
    lock = (texels.uv[:, 0] > frame.left) & (texels.uv[:, 1] > frame.bottom)
    return np.where(lock[:, None], _locks(texels), _shell(texels))


def strands(across: NDArray[np.float64], along: NDArray[np.float64], *, density: float) -> NDArray[np.float32]:
    """Return (N,) -1 to 1: fine lines along the second coordinate that wander a little."""
    wander = 0.6 * noise(np.stack([across * density * 0.2, along * 3, 0 * along], axis=1), 1.0)
    fine = noise(np.stack([across * density + wander, along * 1.3, 0 * along + 5], axis=1), 1.0)
    coarse = noise(np.stack([across * density * 0.3 + wander, along * 0.9, 0 * along + 9], axis=1), 1.0)
    return np.asarray(0.6 * fine + 0.6 * coarse)


def tint(value: NDArray[np.floating]) -> NDArray[np.float64]:
    """Return (N, 3) hair colour for values from -1 (dark) over 0 to 1 (light)."""
    value = np.clip(value, -1, 1)[:, None]
    return np.where(value < 0, MIDDLE + (MIDDLE - DARK) * value, MIDDLE + (LIGHT - MIDDLE) * value)


def _shell(texels: Texels) -> NDArray[np.float64]:
    frame = FRAMES["hair"]
    across, up = ((texels.uv - [frame.left, frame.bottom]) / [frame.width, frame.height]).T
    share = 1 - up
    lines = strands(across, share * 3, density=230.0)
    shade = 0.35 + 0.65 * np.clip(texels.sky, 0, 1)
    colours = tint(lines * 0.75 - 0.35 + 0.2 * (share - 0.6)) * shade[:, None]
    alpha = smoothstep(1.0, 0.86, share + 0.09 * lines)
    return np.concatenate([colours, 255 * alpha[:, None]], axis=1)


def _locks(texels: Texels) -> NDArray[np.float64]:
    frame = FRAMES["lock"]
    across, up = ((texels.uv - [frame.left, frame.bottom]) / [frame.width, frame.height]).T
    share = 1 - up
    kind = np.floor(across * LOCK_KINDS)
    inside = across * LOCK_KINDS - kind
    lines = strands(inside + kind * 3, share, density=16.0)
    colours = tint(lines * 0.9 - 0.35 + 0.5 * share)
    edge = np.abs(inside - 0.5) * 2
    limit = 1.0 - 0.55 * share**1.6 + 0.3 * lines * (0.25 + share)
    alpha = smoothstep(limit + 0.06, limit - 0.12, edge) * smoothstep(0.0, 0.12, share)
    alpha = alpha * smoothstep(1.0, 0.86, share + 0.16 * lines)
    return np.concatenate([colours, 255 * alpha[:, None]], axis=1)
