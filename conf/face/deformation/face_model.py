"""A face that can be deformed: mesh, control points, operator and rig."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import control_point_indices
from conf.face.deformation.constraints.lip_contact import keep_lips_shut
from conf.face.deformation.eyelids import stop_at_contact
from conf.face.deformation.rig import Rig, jaw_offsets
from conf.face.fapu import Fapu, governing, motion_scales
from conf.face.mesh.mesh import Mesh
from conf.face.similarity import IDENTITY, SimilarityTransform

_OUTER_CORNERS = control_point_indices("eye_outer_corner")
_UPPER_LIDS, _LOWER_LIDS = control_point_indices("eyelid_upper"), control_point_indices("eyelid_lower")


@dataclass(frozen=True)
class DeformerOptions:
    """User options of the RBF deformer.

    kernel : a name from KERNELS
    epsilon : locality, 1/cm; None for the kernel's default
    degree : of the polynomial, -1 none to 1 linear; None for the least sound one
    smoothing : lambda; the default halves the effect of tracking noise where two points are close, and keeps every
        point within 0.4 mm of its control point; 0 interpolates exactly
    use_regions : separate lips and lids by regions of influence
    use_ridge_refinement : refine the operator on the face's blendshapes, if it has any
    """

    kernel: str = "multiquadric"
    epsilon: float | None = None
    degree: int | None = None
    smoothing: float = 0.02
    use_regions: bool = True
    use_ridge_refinement: bool = True


@dataclass(frozen=True)
class FaceModel:
    """A neutral face and its deformation, in model centimetres (6.4 between the pupils).

    control_points : (n, 3) float64, neutral
    operator : (V, n) float32, from displacements of the control points to vertex offsets
    smoothing : the lambda of the operator; larger than requested if the system was singular
    rig : rigid parts, if the face has any
    file_to_model : from the file's coordinates to model centimetres
    """

    mesh: Mesh
    control_points: NDArray[np.float64]
    operator: NDArray[np.float32]
    smoothing: float = 0.0
    rig: Rig | None = None
    file_to_model: SimilarityTransform = IDENTITY

    @cached_property
    def neutral(self) -> NDArray[np.float32]:
        """The (V, 3) neutral vertices."""
        return self.mesh.vertices.astype(np.float32)

    @cached_property
    def fapu(self) -> Fapu:
        """The FAPU distances of the neutral face, model centimetres."""
        return Fapu.measure(self.control_points)

    @cached_property
    def _fapu_lengths(self) -> NDArray[np.float32]:
        return self.fapu.lengths().astype(np.float32)

    def deform(
        self,
        displacements: NDArray[np.floating],
        /,
        *,
        sender: Fapu | None = None,
        out: NDArray[np.float32] | None = None,
    ) -> NDArray[np.float32]:
        """Return the deformed vertices, (V, 3) float32, model centimetres.

        displacements : (n, 3) FAPU units, head pose removed
        sender : FAPU of the person who moved, so that all parts move as far as theirs; None for motion of this face
        out : (V, 3) float32 array for the result
        """
        offsets = self._offsets(displacements, sender)
        jaw, points = None if self.rig is None else self.rig.jaw, self.control_points
        remaining = offsets
        if jaw is not None:
            motion = jaw.estimate_motion(points, offsets)
            remaining = offsets - jaw_offsets(jaw.weighted_point_offsets, jaw.point_weights, motion)
        vertices = np.matmul(self.operator, remaining, out=out)
        vertices += self.neutral
        if jaw is not None:
            vertices[jaw.vertices] += jaw_offsets(jaw.weighted_offsets, jaw.weights, motion)
        if self.rig is not None and (teeth := self.rig.upper_teeth) is not None:
            vertices[teeth.vertices, 1] += np.float32(teeth.rise(offsets))
        for eye in () if self.rig is None else self.rig.eyes:
            eye.apply(self.neutral, vertices, points, offsets)
        return vertices

    def _offsets(self, displacements: NDArray[np.floating], sender: Fapu | None) -> NDArray[np.float32]:
        """Return the (n, 3) offsets of the control points, cm; lids and lips stop where they touch."""
        offsets, points = np.asarray(displacements, dtype=np.float32) * self._fapu_lengths, self.control_points
        if sender is not None:
            scales = motion_scales(sender, self.fapu, self._eye_width)
            offsets *= governing(scales).astype(np.float32)
            # Eyes at rest are as narrow as the sender's: lids that close then move as far as theirs.
            gaps = points[_UPPER_LIDS, 1] - points[_LOWER_LIDS, 1]
            offsets[_UPPER_LIDS, 1] += ((scales[4] - 1) * gaps).astype(np.float32)
        if self.rig is None:
            return offsets
        return keep_lips_shut(points, stop_at_contact(points, offsets))

    @cached_property
    def _eye_width(self) -> float:
        """The distance of the outer corners of the eyes, model centimetres."""
        left, right = self.control_points[_OUTER_CORNERS]
        return float(np.linalg.norm(left - right))

    def deformed_points(self, displacements: NDArray[np.floating], /) -> NDArray[np.float32]:
        """Return the (n, 3) displaced control points, model centimetres. displacements : (n, 3) FAPU units."""
        return self.control_points.astype(np.float32) + np.asarray(displacements, np.float32) * self._fapu_lengths

    def to_file_coordinates(self, positions: NDArray[np.floating], /) -> NDArray[np.float64]:
        """Return (..., 3) positions, model centimetres, in the coordinates and unit of the face's file."""
        return self.file_to_model.inverse_apply(np.asarray(positions, np.float64))
