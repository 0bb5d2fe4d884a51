"""Build operator B of one face for different deformer options.

What does not depend on the options (surface graph, anchors, regions, blendshape displacements) is computed once.
"""

from dataclasses import replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from conf.face.control_points import PUPILS
from conf.face.deformation.blendshapes import Blendshapes
from conf.face.deformation.eyelid_helpers import append_helpers, fold_helpers, helpers_on_parabola
from conf.face.deformation.face_model import DeformerOptions, FaceModel
from conf.face.deformation.lid_sealing import seal_lids
from conf.face.deformation.rbf import KERNELS, Operator, build_operator
from conf.face.deformation.regions import Regions, split_regions
from conf.face.deformation.ridge_refinement import refine_with_blendshapes, subtract_jaw_motion
from conf.face.deformation.rig import Rig
from conf.face.head_pose import ES0_CM
from conf.face.mesh.mesh import Mesh
from conf.face.mesh.surface_graph import SurfaceGraph
from conf.face.similarity import IDENTITY, SimilarityTransform

_MIN_ANCHOR_DISTANCE = 0.55  # of a chosen anchor from every control point and anchor, in eye distances
_MAX_ANCHORS = 32


class OperatorBuilder:
    """Operators of one mesh with known control points."""

    def __init__(
        self,
        mesh: Mesh,
        points: NDArray[np.float64],
        rig: Rig | None = None,
        blendshapes: Blendshapes | None = None,
        *,
        file_to_model: SimilarityTransform = IDENTITY,
    ) -> None:
        """points : (n, 3) control points on the mesh, model centimetres; blendshapes : of the same mesh."""
        self._file_to_model = file_to_model
        self._mesh, self._points, self._rig, self._blendshapes = mesh, points, rig, blendshapes

    def build(self, options: DeformerOptions, /) -> Operator:
        """Return operator B for the options.

        Raises ValueError for an unknown kernel, or control points that all coincide.
        """
        if options.kernel not in KERNELS:
            raise ValueError(f"kernel must be one of {', '.join(KERNELS)}, got {options.kernel!r}")
        kernel = KERNELS[options.kernel]
        if options.degree is not None:
            kernel = replace(kernel, degree=options.degree)
        regions = self._split if options.use_regions else self._unrestricted
        measured = None if self._rig is None else self._rig.eyelid_helpers
        helpers = measured or helpers_on_parabola(self._points)
        centres, fields = append_helpers(self._points, regions, helpers)
        operator = build_operator(
            self._mesh.vertices,
            centres,
            kernel=kernel,
            epsilon=options.epsilon or kernel.epsilon,
            regions=fields,
            smoothing=options.smoothing,
        )
        matrix = fold_helpers(operator.matrix, helpers)
        if options.use_ridge_refinement and self._blendshapes is not None:
            matrix = refine_with_blendshapes(matrix, *self._blendshape_motion, regions=regions)
        if self._rig is not None:
            matrix[self._rig.rigid] = 0.0
        if measured is not None:
            matrix = seal_lids(self.face(Operator(matrix, operator.smoothing))).operator
        return Operator(matrix, operator.smoothing)

    def build_face(self, options: DeformerOptions, /) -> FaceModel:
        """Return the face with the operator for the options. Raises ValueError as `build` does."""
        return self.face(self.build(options))

    def face(self, operator: Operator, /) -> FaceModel:
        """Return the face with an operator that this builder, or an equal one, has built."""
        return FaceModel(self._mesh, self._points, operator.matrix, operator.smoothing, self._rig, self._file_to_model)

    @cached_property
    def anchors(self) -> NDArray[np.float64]:
        """The (k, 3) positions that every operator holds still, model centimetres: the rig's, and more far away."""
        initial = None if self._rig is None else self._rig.anchors
        return choose_anchors(self._mesh.vertices, self._points, eye_distance=ES0_CM, initial=initial)

    @cached_property
    def _surface(self) -> SurfaceGraph:
        return SurfaceGraph(self._mesh.vertices, self._mesh.triangles)

    # A pupil rotates its eyeball; skin does not follow it.
    @cached_property
    def _split(self) -> Regions:
        return split_regions(self._surface, self._points, anchors=self.anchors).excluding(PUPILS)

    @cached_property
    def _unrestricted(self) -> Regions:
        return Regions.unrestricted(len(self._mesh.vertices), anchors=self.anchors).excluding(PUPILS)

    @cached_property
    def _blendshape_motion(self) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Displacements of control points and vertex offsets in each blendshape, jaw motion subtracted."""
        assert self._blendshapes is not None
        offsets = self._blendshapes.offsets
        displacements = offsets[:, self._surface.nearest_vertices(self._points, tolerance=0.0)]
        if self._rig is not None and self._rig.jaw is not None:
            return subtract_jaw_motion(self._rig.jaw, self._points, displacements, offsets)
        return displacements, offsets


def choose_anchors(
    vertices: NDArray[np.float64],
    points: NDArray[np.float64],
    /,
    *,
    eye_distance: float,
    initial: NDArray[np.float64] | None = None,
) -> NDArray[np.float64]:
    """Pick anchors, which stay still whatever the control points do: vertices far from these, farthest first.

    vertices : (V, 3), points : (n, 3), initial : (k, 3) given anchors, all in one length unit
    Returns at most 32 anchors, the initial ones first; none on a mask that ends where the control points end.
    """
    chosen = [] if initial is None else list(initial)
    distance = np.asarray(KDTree(points).query(vertices)[0])
    outside = distance > _MIN_ANCHOR_DISTANCE * eye_distance
    candidates, distance = vertices[outside], distance[outside]
    for anchor in chosen:
        distance = np.minimum(distance, np.linalg.norm(candidates - anchor, axis=1))
    while len(chosen) < _MAX_ANCHORS and len(candidates) and distance.max() > _MIN_ANCHOR_DISTANCE * eye_distance:
        chosen.append(candidates[distance.argmax()])
        distance = np.minimum(distance, np.linalg.norm(candidates - chosen[-1], axis=1))
    return np.array(chosen).reshape(-1, 3)
