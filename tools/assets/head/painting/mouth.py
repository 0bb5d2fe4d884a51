"""Paint the inside of the mouth: teeth with gums, tongue, the dark cavity."""

import numpy as np
from numpy.typing import NDArray

from tools.assets.head.painting.noise import layered, noise, smoothstep
from tools.assets.head.painting.texels import Texels
from tools.assets.head.parameters import HeadParameters
from tools.assets.head.part import FRAMES

_ENAMEL = np.array([244.0, 235, 220])
_GUM = np.array([172.0, 98, 92])
_TONGUE = np.array([176.0, 98, 92])
_CAVITY = np.array([112.0, 46, 44])


def paint_teeth(texels: Texels, head: HeadParameters) -> NDArray[np.float64]:
    """Return (N, 3) sRGB colours 0 to 255."""
    frame = FRAMES["teeth"]
    along, height = ((texels.uv - [frame.left, frame.bottom]) / [frame.width, frame.height]).T
    section = (1 - (height % 0.5) * 2) * 9  # row of the cross-section, 0 at the root of the gum
    neck = 2.0 + 0.25 * noise(texels.position * [3, 0, 3], 1.0)
    gum = smoothstep(neck + 0.5, neck - 0.3, section)[:, None]
    inside = smoothstep(6.6, 8.0, section)[:, None]
    colours = _ENAMEL * (1 + 0.02 * layered(texels.position, 3.0, 2))[:, None]
    colours = colours * (1 - 0.1 * smoothstep(4.5, 2.2, section)[:, None] * [0.2, 0.6, 1.6])
    colours = colours + (_GUM - colours) * gum
    colours = colours * (1 - 0.55 * inside)
    back = smoothstep(0.16, 0.5, np.abs(along - 0.5))[:, None]
    return np.clip(colours * (1 - 0.6 * back * [0.85, 1, 1]), 0, 255)


def paint_tongue(texels: Texels, head: HeadParameters) -> NDArray[np.float64]:
    """Return (N, 3) sRGB colours 0 to 255."""
    x, _, z = texels.position.T
    furrow = np.exp(-((x / 0.18) ** 2))
    colours = _TONGUE * (1 + 0.07 * noise(texels.position, 9.0) - 0.1 * furrow)[:, None]
    back = smoothstep(3.2, -2.0, z)[:, None]
    return np.asarray(np.clip(colours * (1 - 0.7 * back), 0, 255))


def paint_cavity(texels: Texels, head: HeadParameters) -> NDArray[np.float64]:
    """Return (N, 3) sRGB colours 0 to 255, darker with depth."""
    back = smoothstep(4.6, 0.5, texels.position[:, 2])[:, None]
    colours = _CAVITY * (1 + 0.08 * layered(texels.position, 1.5, 2))[:, None]
    return np.clip(colours * (1 - 0.78 * back), 0, 255)
