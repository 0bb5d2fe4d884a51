"""Synthetic motion for tests: a talking, blinking, nodding face."""

import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import (
    CONTROL_POINT_COUNT,
    CONTROL_POINT_INDEX,
    LOWER_LIP,
    UPPER_LID,
    control_point_indices,
)
from conf.protocol.messages import MotionFrame

TYPICAL_POSE = np.array([0.05, -0.1, 0.02, 0.03, -0.02, -3.7])


def wave(tick: int, period: int) -> float:
    """Return a triangular wave between 0 and 1. No sine, so that every machine computes the same bits."""
    return abs(2 * (tick % period) / period - 1)


def talking(count: int, *, first: int = 0) -> list[MotionFrame]:
    """Return frames of a face that opens its mouth, blinks and nods."""
    return [_frame(tick) for tick in range(first, first + count)]


def still(count: int) -> list[MotionFrame]:
    """Return frames of a face without motion."""
    return [MotionFrame(n / 15, np.zeros((CONTROL_POINT_COUNT, 3), np.float32), TYPICAL_POSE) for n in range(count)]


def grimace(count: int) -> list[MotionFrame]:
    """Return frames of a still face whose nose, left brow and lip lie far outside the training data."""
    displacements = np.zeros((CONTROL_POINT_COUNT, 3), np.float32)
    displacements[CONTROL_POINT_INDEX["nose_bottom_edge_l"]] = [150, 90, 0]
    displacements[CONTROL_POINT_INDEX["brow_outer_l"]] = [0, -140, 40]
    displacements[CONTROL_POINT_INDEX["inner_lip_upper_mid"]] = [70, 120, 0]
    return [MotionFrame(n / 15, displacements, TYPICAL_POSE) for n in range(count)]


def _frame(tick: int) -> MotionFrame:
    opening, nod = wave(tick, 9), wave(tick, 47) - 0.5
    displacements: NDArray[np.float32] = np.zeros((CONTROL_POINT_COUNT, 3), np.float32)
    displacements[[*LOWER_LIP, *control_point_indices("chin")], 1] = -300 * opening
    displacements[UPPER_LID, 1] = -700 if tick % 40 < 3 else 0
    displacements[control_point_indices("brow"), 1] = 60 * wave(tick, 31)
    return MotionFrame(tick / 15, displacements, TYPICAL_POSE + nod * np.array([0.2, 0.1, 0, 0, 0.02, 0]))
