"""Paint the eyeball: iris with a dark rim, pupil, sclera shaded near the lids, fine vessels."""

import numpy as np
from numpy.typing import NDArray

from tools.assets.head.eyeballs import CAP_ANGLE, IRIS_ANGLE
from tools.assets.head.painting.noise import noise, smoothstep
from tools.assets.head.painting.texels import Texels
from tools.assets.head.parameters import HeadParameters
from tools.assets.head.part import FRAMES

_SCLERA = (218, 208, 201)
_RIM = (36, 30, 28)
_PUPIL = (10, 9, 9)
_PUPIL_ANGLE = 0.135


def paint_eye(texels: Texels, head: HeadParameters) -> NDArray[np.float64]:
    """Return (N, 3) sRGB colours 0 to 255."""
    frame = FRAMES["eye"]
    x, y = ((texels.uv - [frame.left, frame.bottom]) / [frame.width, frame.height] - 0.5).T * 2
    around = np.arctan2(y, x)
    angle = (x**2 + y**2) * CAP_ANGLE
    wheel = np.stack([np.cos(around), np.sin(around), 0 * around], axis=1)
    colours = _sclera(angle, around, wheel)
    rays = noise(wheel * 7.0 + [0, 0, 3], 1.0) * 0.5 + noise(wheel * 16.0, 1.0) * 0.5
    rays += 0.35 * noise(np.stack([around * 0, angle * 20, around * 6], axis=1), 1.0)
    depth = np.clip((angle - _PUPIL_ANGLE) / (IRIS_ANGLE - _PUPIL_ANGLE), 0, 1)[:, None]
    iris = np.array(head.eyes.iris_inner) * (1 - depth) + np.array(head.eyes.iris_outer) * depth
    iris = iris * (1 + 0.26 * rays[:, None]) * (1 - 0.35 * smoothstep(0.0, 0.9, np.sin(around))[:, None])
    rim = smoothstep(0.62, 1.0, depth)
    iris += (np.array(_RIM) - iris) * 0.85 * rim
    pupil = smoothstep(_PUPIL_ANGLE + 0.02, _PUPIL_ANGLE - 0.012, angle)[:, None]
    iris += (np.array(_PUPIL) - iris) * pupil
    inside = smoothstep(IRIS_ANGLE + 0.03, IRIS_ANGLE - 0.03, angle)[:, None]
    colours += (iris - colours) * inside
    return np.clip(colours, 0, 255)


def _sclera(angle: NDArray[np.float64], around: NDArray[np.float64], wheel: NDArray[np.float64]) -> NDArray[np.float64]:
    colours = np.tile(np.array(_SCLERA, dtype=float), (len(angle), 1))
    height, side = angle * np.sin(around), angle * np.cos(around)
    shade = 0.42 * smoothstep(0.06, 0.42, height) + 0.22 * smoothstep(-0.2, -0.55, height)
    shade += 0.3 * smoothstep(0.5, 0.95, np.abs(side))
    colours *= 1 - np.clip(shade, 0, 0.75)[:, None] * np.array([0.82, 0.95, 1.0])
    vessels = smoothstep(0.55, 0.9, noise(wheel * angle[:, None] * 14, 1.0)) * smoothstep(0.5, 1.0, angle)
    colours += (np.array([206, 130, 118]) - colours) * (0.25 * vessels + 0.22 * smoothstep(0.6, 1.1, angle))[:, None]
    return colours
