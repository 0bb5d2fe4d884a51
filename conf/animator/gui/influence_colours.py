"""Regions of influence as colours: which control points move which part of the face, read off operator B."""

import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import LOWER_LID, LOWER_LIP, UPPER_LID, UPPER_LIP, control_point_indices

# sRGB, as far apart as neighbours on a face need to be.
REGIONS: dict[str, tuple[list[int], tuple[int, int, int]]] = {
    "upper lip": (UPPER_LIP, (232, 84, 98)),
    "lower lip": (LOWER_LIP, (248, 170, 60)),
    "lip corners": (control_point_indices("inner_lip_corner", "outer_lip_corner"), (205, 110, 220)),
    "chin": (control_point_indices("chin"), (150, 205, 90)),
    "cheeks": (control_point_indices("cheek"), (70, 180, 165)),
    "nose": (control_point_indices("nose", "nostril"), (245, 225, 110)),
    "upper lids": (UPPER_LID, (90, 150, 245)),
    "lower lids": (LOWER_LID, (130, 215, 245)),
    "eye corners": (control_point_indices("eye_inner", "eye_outer"), (160, 140, 245)),
    "brows": (control_point_indices("brow"), (240, 140, 185)),
}
UNAFFECTED = (104, 108, 116)  # what no control point moves
LOW, HOT = (72, 80, 94), (255, 214, 96)


def region_colours(operator: NDArray[np.float32], /) -> NDArray[np.float32]:
    """Return (V, 3) sRGB 0 to 1: each vertex the mixture of the regions that move it, grey where none does.

    What counts is how far the vertex goes when all points of a region go together: single columns of B swing to both
    sides far away and take each other back.
    operator : (V, n)
    """
    together = np.stack([operator[:, rows].sum(axis=1) for rows, _ in REGIONS.values()], axis=1)
    shares = together**2
    palette = np.array([colour for _, colour in REGIONS.values()], np.float32) / 255
    mixture = shares @ palette / np.maximum(shares.sum(axis=1, keepdims=True), 1e-12)
    moved = np.clip(1.5 * np.sqrt(shares.sum(axis=1, keepdims=True)) - 0.1, 0.0, 1.0)
    return np.asarray(moved * mixture + (1 - moved) * np.array(UNAFFECTED, np.float32) / 255, np.float32)


def point_colours(operator: NDArray[np.float32], point: int, /) -> NDArray[np.float32]:
    """Return (V, 3) sRGB 0 to 1: how far each vertex follows one control point."""
    share = np.clip(np.abs(operator[:, point]), 0.0, 1.0)[:, None]
    cold, hot = np.array(LOW, np.float32) / 255, np.array(HOT, np.float32) / 255
    return np.asarray(cold + share * (hot - cold), np.float32)
