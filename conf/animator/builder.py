"""Build operator B of one face again and again, as its user changes kernel, locality, polynomial, lambda, regions.

What does not depend on these - the surface, the anchors, the regions - is found once. Nothing is kept on disk: a slider
that is dragged would fill the cache with what nobody asks for again.
"""

from dataclasses import replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from conf.animator.face_document import FaceDocument
from conf.face.control_points import PUPILS
from conf.face.deformation.anchors import choose_anchors
from conf.face.deformation.eyelid_helpers import append_helpers, fold_helpers
from conf.face.deformation.face_model import DeformerOptions, FaceModel
from conf.face.deformation.kernels import KERNELS
from conf.face.deformation.rbf import build_operator
from conf.face.deformation.regions import Regions, split_regions
from conf.face.deformation.ridge_refinement import refine_with_blendshapes, subtract_jaw_motion
from conf.face.fapu import Fapu
from conf.face.head_pose import ES0_CM
from conf.face.mesh.surface_graph import SurfaceGraph


class FaceBuilder:
    """Makes faces of one subject whose control points are known."""

    def __init__(self, subject: FaceDocument) -> None:
        if subject.points is None:
            raise ValueError("subject must have control points")
        self.subject = subject
        self._points: NDArray[np.float64] = subject.points

    def build(self, deformer: DeformerOptions, /) -> FaceModel:
        """Return the face as this deformer moves it.

        Raises ValueError for an unknown kernel, or control points that all lie in one place.
        """
        if deformer.kernel not in KERNELS:
            raise ValueError(f"kernel must be one of {', '.join(KERNELS)}, got {deformer.kernel!r}")
        subject, points = self.subject, self._points
        kernel = KERNELS[deformer.kernel]
        if deformer.degree is not None:
            kernel = replace(kernel, degree=deformer.degree)
        regions = self._split if deformer.use_regions else self._whole
        margins = None if subject.rig is None else subject.rig.margins
        centres, fields = append_helpers(points, regions, margins)
        operator = build_operator(
            subject.mesh.vertices,
            centres,
            kernel=kernel,
            epsilon=deformer.epsilon or kernel.epsilon,
            regions=fields,
            smoothing=deformer.smoothing,
        )
        matrix = fold_helpers(operator.matrix, margins)
        if deformer.use_ridge_refinement and subject.shapes is not None:
            matrix = refine_with_blendshapes(matrix, *self._sculpted, regions=regions)
        if subject.rig is not None:
            matrix[subject.rig.rigid] = 0.0
        return FaceModel(
            subject.mesh, points, Fapu.measure(points), matrix, operator.smoothing, subject.rig, subject.placement
        )

    @cached_property
    def _surface(self) -> SurfaceGraph:
        return SurfaceGraph(self.subject.mesh.vertices, self.subject.mesh.triangles)

    @cached_property
    def _anchors(self) -> NDArray[np.float64]:
        known = None if self.subject.rig is None else self.subject.rig.anchors
        return choose_anchors(self.subject.mesh.vertices, self._points, eye_distance=ES0_CM, initial=known)

    @cached_property
    def _split(self) -> Regions:
        return split_regions(self._surface, self._points, anchors=self._anchors).excluding(PUPILS)

    @cached_property
    def _whole(self) -> Regions:
        return Regions.unrestricted(len(self.subject.mesh.vertices), anchors=self._anchors).excluding(PUPILS)

    @cached_property
    def _sculpted(self) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Displacements of the control points and offsets of the vertices in each sculpted shape, the jaw taken out."""
        shapes, rig = self.subject.shapes, self.subject.rig
        assert shapes is not None
        displacements = shapes.offsets_at(self._surface.nearest_vertices(self._points, tolerance=0.0))
        if rig is not None and rig.jaw is not None:
            return subtract_jaw_motion(rig.jaw, self._points, displacements, shapes.offsets)
        return displacements, shapes.offsets
