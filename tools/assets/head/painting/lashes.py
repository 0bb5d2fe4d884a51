"""Paint the eyelashes hair by hair, the upper row above the lower row."""

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import map_coordinates

from tools.assets.head.painting.texels import Texels
from tools.assets.head.parameters import HeadParameters
from tools.assets.head.part import FRAMES

_WIDTH, _HEIGHT = 900, 128
_SUBPIXEL = 16
_HAIRS = {"upper": 84, "lower": 40}


def paint_lashes(texels: Texels, head: HeadParameters) -> NDArray[np.float64]:
    """Return (N, 4) sRGB colours and alpha, 0 to 255."""
    frame = FRAMES["lashes"]
    across, up = ((texels.uv - [frame.left, frame.bottom]) / [frame.width, frame.height]).T
    upper = up > 0.5
    reach = np.where(upper, up * 2 - 1, up * 2)
    alpha = np.zeros(len(up))
    for row, in_row in (("upper", upper), ("lower", ~upper)):
        sheet = _draw(_HAIRS[row], np.random.default_rng(11 if row == "upper" else 12))
        drawn = map_coordinates(sheet, [reach * (_HEIGHT - 1), across * (_WIDTH - 1)], order=1, mode="nearest")
        alpha = np.where(in_row, drawn * (0.85 if row == "upper" else 0.5), alpha)
    return np.concatenate([np.tile(np.array(head.eyes.lash, float), (len(up), 1)), 255 * alpha[:, None]], axis=1)


def _draw(count: int, random: np.random.Generator) -> NDArray[np.float32]:
    """Return the (height, width) coverage, 0 to 1; row 0 is the lid margin."""
    sheet = np.zeros((_HEIGHT, _WIDTH), dtype=np.uint8)
    step = _WIDTH / count
    for i in range(count):
        x = (i + random.uniform(0.1, 0.9)) * step
        height = _HEIGHT * random.uniform(0.55, 0.98)
        lean = random.normal(0, 1.3) * step + np.sin(i * 1.9) * step  # neighbours form small tufts
        for width, length in ((6, 0.35), (4, 0.7), (2, 1.0)):
            t = np.linspace(0, length, 8)
            path = np.stack([x + lean * t**1.4, t * height], axis=1)
            cv2.polylines(sheet, [(path * _SUBPIXEL).astype(np.int32)], False, 255, width, cv2.LINE_AA, 4)
    root = np.exp(-np.arange(_HEIGHT) / 9.0)[:, None] * 0.8
    return np.maximum(cv2.GaussianBlur(sheet, (0, 0), 1.0).astype(np.float32) / 255, root.astype(np.float32))
