"""The neck: the head turns, the shoulders hardly follow.

Strategy. The whole face is drawn with the head's pose. Before that, what lies below the chin is turned back about the
neck, the more the lower it lies: all of the head stays where the pose puts it, and points can be projected as before.
"""

import math

import numpy as np
from numpy.typing import NDArray

from conf.face.head_pose import HeadPose
from conf.face.interpolation import smoothstep
from conf.face.mesh.mesh import Mesh

TORSO = "shirt"  # faces without this group have no shoulders, and are drawn as one piece
PIVOT = np.array([0.0, -13.0, -8.0], dtype=np.float32)  # in the middle of the neck; model centimetres, as the next
TOP, BOTTOM = -10.0, -19.0  # the neck bends between these heights
NECK_RADIUS = 6.0  # farther out the shoulders begin, and go with the head less than the neck at the same height
SHOULDER_WEIGHT = 0.22  # how much of the head's turn


def head_weights(vertices: NDArray[np.floating], /) -> NDArray[np.float64]:
    """Return (V,) how far each vertex (V, 3) goes with the head: 1 head, 0 shoulders."""
    beside = np.maximum(np.hypot(vertices[:, 0] - PIVOT[0], vertices[:, 2] - PIVOT[2]) - NECK_RADIUS, 0.0)
    depth = (TOP - vertices[:, 1]) / (TOP - BOTTOM) * (1.0 + 0.5 * beside)
    return np.asarray(1.0 - smoothstep(depth))


class NeckBend:
    """Bends one face below its chin."""

    def __init__(self, mesh: Mesh) -> None:
        share = head_weights(mesh.vertices) if TORSO in mesh.groups else np.ones(len(mesh.vertices))
        self._below = np.flatnonzero(share < 1.0)
        self._back = ((1.0 - SHOULDER_WEIGHT) * (1.0 - share[self._below])).astype(np.float32)[:, None]
        self._bent = mesh.vertices.astype(np.float32)

    def apply(self, vertices: NDArray[np.float32], pose: HeadPose, /) -> NDArray[np.float32]:
        """Return the (V, 3) vertices with neck and shoulders turned back. The array is used again by the next call.

        vertices : (V, 3) float32, face axes, cm
        """
        angle = math.sqrt(float(pose.rotation @ pose.rotation))
        if not len(self._below) or angle < 1e-6:
            return vertices
        axis = (pose.rotation / angle).astype(np.float32)
        np.copyto(self._bent, vertices)
        arms = vertices[self._below] - PIVOT
        turn = -np.float32(angle) * self._back
        along = arms @ axis[:, None] * axis
        self._bent[self._below] = PIVOT + along + (arms - along) * np.cos(turn) + np.cross(axis, arms) * np.sin(turn)
        return self._bent
