"""The plain codec: every number as a 16-bit integer. 312 bytes for fifty points and a pose, always, without state."""

import numpy as np
from numpy.typing import NDArray

from conf.errors import ProtocolError

INT16 = np.dtype(">i2")
POSE_STEPS = np.array([1e-4, 1e-4, 1e-4, 1e-4, 1e-4, 1e-3])  # radians, picture heights, log
POSE_NUMBERS = len(POSE_STEPS)


def encode_motion(displacements: NDArray[np.floating], pose: NDArray[np.floating], /) -> bytes:
    """Quantise one frame to whole FAPU units and POSE_STEPS.

    displacements : (n, 3), FAPU units; pose : (6,) as HeadPose's vector
    Returns 2 (6 + 3 n) bytes; what does not fit in 16 bits is cut off at the largest number that does.
    """
    numbers = np.concatenate([pose / POSE_STEPS, np.ravel(displacements)])
    data: bytes = np.clip(np.rint(numbers), -32768, 32767).astype(INT16).tobytes()
    return data


def decode_motion(data: bytes, points: int, /) -> tuple[NDArray[np.float32], NDArray[np.float64]]:
    """Return displacements (points, 3) and pose (6,), or raise ProtocolError when the length is wrong."""
    if len(data) != INT16.itemsize * (POSE_NUMBERS + 3 * points):
        raise ProtocolError(f"motion of {len(data)} bytes does not carry {points} points")
    numbers = np.frombuffer(data, dtype=INT16).astype(np.float64)
    pose = numbers[:POSE_NUMBERS] * POSE_STEPS
    return numbers[POSE_NUMBERS:].reshape(points, 3).astype(np.float32), pose
