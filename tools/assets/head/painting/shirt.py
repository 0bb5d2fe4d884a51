"""Paint the shirt: dark knitted cotton, a ribbed collar with a seam, darker towards the rim."""

import numpy as np
from numpy.typing import NDArray

from tools.assets.head.painting.noise import layered, noise, smoothstep
from tools.assets.head.painting.texels import Texels
from tools.assets.head.parameters import HeadParameters
from tools.assets.head.part import FRAMES

_COLLAR_HEIGHT = 0.25  # relative to the height of the texture, as the rows of ../shirt.py


def paint_shirt(texels: Texels, head: HeadParameters) -> NDArray[np.float64]:
    """Return (N, 3) sRGB colours 0 to 255."""
    frame = FRAMES["shirt"]
    across, up = ((texels.uv - [frame.left, frame.bottom]) / [frame.width, frame.height]).T
    down = 1 - up
    collar = smoothstep(_COLLAR_HEIGHT + 0.006, _COLLAR_HEIGHT - 0.006, down)
    ribs = np.cos(across * 2 * np.pi * 150)
    light = 1 + 0.08 * layered(texels.position, 0.35, 3) + 0.04 * noise(texels.position, 6.0)
    light = light * (1 + collar * (0.1 * ribs - 0.02))
    light = light * (1 - 0.45 * np.exp(-(((down - _COLLAR_HEIGHT) / 0.012) ** 2)))
    light = light * (0.7 + 0.3 * smoothstep(-34, -26, texels.position[:, 1]))
    light = light * (0.45 + 0.55 * np.clip(texels.sky, 0, 1))
    return np.asarray(np.clip(np.array(head.shirt, float) * light[:, None], 0, 255))
