"""Measure rendered images in tests."""

import numpy as np
from numpy.typing import NDArray

from conf.render.render_target import paint_background

Pixels = NDArray[np.uint8]


def drawn(pixels: Pixels) -> NDArray[np.bool_]:
    """Return (H, W) bool: where something is drawn over the background."""
    background = paint_background((pixels.shape[1], pixels.shape[0]))[::-1, :, 2::-1]
    return np.asarray((np.abs(pixels.astype(int) - background) > 3).any(axis=2))


def box(mask: NDArray[np.bool_] | np.bool_) -> tuple[int, int, int, int]:
    """Return left, top, right and bottom of the True pixels, the last two exclusive."""
    ys, xs = np.nonzero(mask)
    return int(xs.min()), int(ys.min()), int(xs.max()) + 1, int(ys.max()) + 1
