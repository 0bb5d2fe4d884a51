"""Bend the neck: the shoulders follow only a part of the head's rotation.

Strategy. The whole face is drawn with the head's pose. Before that, what lies below the chin is rotated back about the
neck, the more the lower it lies. The head itself stays where the pose puts it, and points are projected unchanged.
"""

import math

import numpy as np
from numpy.typing import NDArray

from conf.face.deformation.rig import cross_matrix
from conf.face.head_pose import HeadPose
from conf.face.interpolation import smoothstep
from conf.face.mesh.mesh import Mesh

TORSO = "shirt"  # faces without this group have no shoulders and are drawn in one piece
# Model centimetres.
PIVOT = np.array([0.0, -13.0, -8.0], dtype=np.float32)  # in the middle of the neck
# The neck bends between two planes y = level + SLOPE z, which fall towards the front as collar and jaw do. Below
# the lower one, a centimetre above the collar, skin and shirt turn as one, so that neither comes through the other.
SLOPE = -0.35
TOP, BOTTOM = -10.1, -16.1
SHOULDER_WEIGHT = 0.22  # of the head's rotation


def head_weights(vertices: NDArray[np.floating], /) -> NDArray[np.float64]:
    """Return the (V,) weight by which each vertex (V, 3) follows the head: 1 head, 0 shoulders."""
    level = vertices[:, 1] - SLOPE * vertices[:, 2]
    return np.asarray(1.0 - smoothstep((TOP - level) / (TOP - BOTTOM)))


class NeckBend:
    """Rotates neck and shoulders of one mesh back."""

    def __init__(self, mesh: Mesh) -> None:
        weights = np.ones(len(mesh.vertices))
        if TORSO in mesh.groups:
            weights = head_weights(mesh.vertices)
            weights[mesh.group_vertices(TORSO)] = 0.0
        self._below = np.flatnonzero(weights < 1.0)
        self._fraction = ((1.0 - SHOULDER_WEIGHT) * (1.0 - weights[self._below])).astype(np.float32)[:, None]
        self._bent = mesh.vertices.astype(np.float32)

    def apply(self, vertices: NDArray[np.float32], pose: HeadPose, /) -> NDArray[np.float32]:
        """Return the (V, 3) vertices with neck and shoulders rotated back. The next call overwrites the array.

        vertices : (V, 3) float32, face axes, cm
        """
        angle = math.sqrt(float(pose.rotation @ pose.rotation))
        if not len(self._below) or angle < 1e-6:
            return vertices
        axis = (pose.rotation / angle).astype(np.float32)
        np.copyto(self._bent, vertices)
        arms = vertices[self._below] - PIVOT
        angles = -np.float32(angle) * self._fraction
        along = arms @ axis[:, None] * axis
        # Rodrigues' rotation formula.
        across = arms @ cross_matrix(axis).T.astype(np.float32)
        rotated = PIVOT + along + (arms - along) * np.cos(angles) + across * np.sin(angles)
        self._bent[self._below] = rotated
        return self._bent
