"""How far the lips of a deformed face are open: little light reaches the teeth through a slit."""

import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_INDEX
from conf.face.deformation.face_model import FaceModel

INNER_LIPS = [CONTROL_POINT_INDEX[f"inner_lip_{lip}_mid"] for lip in ("upper", "lower")]
_TOLERANCE = 0.15  # cm by which the vertex of a lip may be farther from its control point than the nearest one
_MAX_CLOSED = 0.25  # cm from lip to lip up to which a neutral mouth counts as closed


class LipOpening:
    """Measures the distance from lip to lip in the middle of one face's mouth."""

    def __init__(self, face: FaceModel) -> None:
        """Choose a vertex on either lip that follows it: where lips touch, the nearest may be the other one's."""
        self._vertices: list[int] = []
        for point in INNER_LIPS:
            distance = np.linalg.norm(face.mesh.vertices - face.control_points[point], axis=1)
            near = np.flatnonzero(distance <= distance.min() + _TOLERANCE)
            self._vertices.append(int(near[face.operator[near, point].argmax()]))
        self._closed = min(self._distance(face.neutral), _MAX_CLOSED)

    def measure(self, vertices: NDArray[np.float32]) -> float:
        """Return the distance, cm, for deformed vertices (V, 3); 0 for a neutral mouth that is closed or nearly so."""
        return self._distance(vertices) - self._closed

    def upper(self, vertices: NDArray[np.float32]) -> float:
        """Return the height of the upper lip's inner edge, cm."""
        return float(vertices[self._vertices[0], 1])

    def _distance(self, vertices: NDArray[np.float32]) -> float:
        upper, lower = vertices[self._vertices, 1].tolist()
        return float(upper - lower)
