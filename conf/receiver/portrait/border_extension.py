"""What lies beyond a photograph's border: its colours go on, softer the farther out, or a head cut off has streaks."""

import numpy as np
from numpy.typing import NDArray

from conf.face.portrait.person_outline import BORDER_EXTENSION
from conf.receiver.portrait.inpainting import push_pull_fill


def extend_border(
    colours: NDArray[np.uint8], share: NDArray[np.uint8], /
) -> tuple[NDArray[np.uint8], NDArray[np.uint8], NDArray[np.float64]]:
    """Return colours and share with a margin all around, and the margin's width and height as shares of the picture's.

    colours : (H, W, 3) uint8; share : (H, W) uint8
    """
    height, width = share.shape
    margin = int(np.ceil(BORDER_EXTENSION * height))
    both = np.pad(np.dstack([colours, share]).astype(np.float32), ((margin, margin), (margin, margin), (0, 0)))
    known = np.pad(np.ones((height, width), bool), margin)
    filled = np.clip(np.rint(push_pull_fill(both, known)), 0, 255).astype(np.uint8)
    return filled[..., :3], filled[..., 3], np.array([margin / width, margin / height])
