"""A face that can be moved: mesh, control points, operator and rigid parts together."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from conf.face.deformation.rig import Rig, jaw_offsets
from conf.face.fapu import Fapu
from conf.face.mesh.mesh import Mesh
from conf.face.similarity import IDENTITY, SimilarityTransform


@dataclass(frozen=True)
class DeformerOptions:
    """How control points carry the skin: what the user may choose.

    kernel : a name from KERNELS
    epsilon : locality, 1/cm; None takes the kernel's own
    degree : of the polynomial, -1 none to 1 linear; None takes the least that is sound
    smoothing : lambda; a little halves what the tracker's noise does to the skin where two points are close, and keeps
        every point within 0.4 mm of where it is told to be; 0 keeps it there exactly
    split : keep the lips and the lids apart by regions of influence
    learned : refine the operator on the face's sculpted shapes, if it has any
    """

    kernel: str = "multiquadric"
    epsilon: float | None = None
    degree: int | None = None
    smoothing: float = 0.02
    use_regions: bool = True
    use_ridge_refinement: bool = True


@dataclass(frozen=True)
class FaceModel:
    """A neutral face and what moves it, in model centimetres (6.4 between the pupils).

    control_points : (n, 3) float64, neutral
    fapu : the face's own units
    operator : (V, n) float32, vertex offsets for displacements of the control points
    smoothing : the lambda the operator took; more than asked for says that the system was singular
    rig : rigid parts, if the face has any
    placement : what carried the file's coordinates to model centimetres
    """

    mesh: Mesh
    control_points: NDArray[np.float64]
    fapu: Fapu
    operator: NDArray[np.float32]
    smoothing: float = 0.0
    rig: Rig | None = None
    file_to_model: SimilarityTransform = IDENTITY

    @cached_property
    def neutral(self) -> NDArray[np.float32]:
        """The (V, 3) vertices at rest."""
        return self.mesh.vertices.astype(np.float32)

    @cached_property
    def _fapu_lengths(self) -> NDArray[np.float32]:
        return self.fapu.lengths().astype(np.float32)

    def deform(
        self, displacements: NDArray[np.floating], /, *, out: NDArray[np.float32] | None = None
    ) -> NDArray[np.float32]:
        """Move the face.

        displacements : (n, 3) FAPU units, head pose removed
        out : (V, 3) float32 to write to; without it a new array is made
        Returns (V, 3) float32, model centimetres.
        """
        offsets = np.asarray(displacements, dtype=np.float32) * self._fapu_lengths
        if self.rig is None:
            vertices = np.matmul(self.operator, offsets, out=out)
            vertices += self.neutral
            return vertices
        carried, jaw, points = offsets, self.rig.jaw, self.control_points
        if jaw is not None:
            motion = jaw.estimate_motion(points, offsets)
            carried = offsets - jaw_offsets(jaw.weighted_point_offsets, jaw.point_weights, motion)
        vertices = np.matmul(self.operator, carried, out=out)
        vertices += self.neutral
        if jaw is not None:
            vertices[jaw.vertices] += jaw_offsets(jaw.weighted_offsets, jaw.weights, motion)
        for eye in self.rig.eyes:
            eye.apply(self.neutral, vertices, np.stack([points[eye.pupil], offsets[eye.pupil]]))
        return vertices

    def deformed_points(self, displacements: NDArray[np.floating], /) -> NDArray[np.float32]:
        """Return the (n, 3) control points where the displacements (FAPU units) have taken them, model centimetres."""
        return self.control_points.astype(np.float32) + np.asarray(displacements, dtype=np.float32) * self._fapu_lengths

    def to_file_coordinates(self, places: NDArray[np.floating], /) -> NDArray[np.float64]:
        """Return (..., 3) places, model centimetres, in the coordinates and the unit of the face's own file."""
        return self.file_to_model.inverse_apply(np.asarray(places, np.float64))
