"""Colours that show which control points move which part of the face, computed from the operator."""

import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import LOWER_LID, LOWER_LIP, UPPER_LID, UPPER_LIP, control_point_indices

# sRGB; neighbouring regions have clearly different hues.
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
UNAFFECTED = (104, 108, 116)  # of vertices that no control point moves
LOW, HIGH = (72, 80, 94), (255, 214, 96)


def region_colours(operator: NDArray[np.float32], /) -> NDArray[np.float32]:
    """Return (V, 3) sRGB 0 to 1: each vertex the mixture of the regions that move it, grey where none does.

    The weight of a region is the vertex's response when all its points move together. Single columns of the operator
    oscillate far from their point and cancel each other.
    operator : (V, n)
    """
    responses = np.stack([operator[:, points].sum(axis=1) for points, _ in REGIONS.values()], axis=1)
    weights = responses**2
    total = weights.sum(axis=1, keepdims=True)
    palette = np.array([colour for _, colour in REGIONS.values()], np.float32) / 255
    mixture = weights @ palette / np.maximum(total, 1e-12)
    alpha = np.clip(1.5 * np.sqrt(total) - 0.1, 0.0, 1.0)
    return np.asarray(alpha * mixture + (1 - alpha) * np.array(UNAFFECTED, np.float32) / 255, np.float32)


def point_colours(operator: NDArray[np.float32], point: int, /) -> NDArray[np.float32]:
    """Return (V, 3) sRGB 0 to 1: LOW to HIGH by each vertex's response to one control point."""
    weight = np.clip(np.abs(operator[:, point]), 0.0, 1.0)[:, None]
    low, high = np.array(LOW, np.float32) / 255, np.array(HIGH, np.float32) / 255
    return np.asarray(low + weight * (high - low), np.float32)
