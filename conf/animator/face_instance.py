"""An open face: its document, its deformable model, its renderer, and the background builds of the model."""

import time
from collections.abc import Mapping

import moderngl
import numpy as np
from numpy.typing import NDArray

from conf.animator.background_fit import LatestTaskWorker
from conf.animator.face_document import FaceDocument
from conf.animator.face_view import FaceView
from conf.animator.picking import Picker
from conf.animator.state.editor import MuscleState
from conf.face.control_points import CONTROL_POINT_COUNT
from conf.face.default_head import DEFAULT_HEAD
from conf.face.deformation.face_model import DeformerOptions, FaceModel
from conf.face.deformation.facial_muscles import MuscleDeformer
from conf.face.deformation.operator_builder import OperatorBuilder
from conf.face.formats.ppc import read_ppc


class FaceInstance:
    """One face on the GPU.

    model : with the newest operator that is built; build_ms : time of that build, milliseconds
    """

    def __init__(self, ctx: moderngl.Context, document: FaceDocument, deformer: DeformerOptions) -> None:
        self.document = document
        self._builder = None if document.points is None else document.operator_builder()
        self.model, self.build_ms = (
            (face_without_points(document), 0.0) if self._builder is None else _build(self._builder, deformer)
        )
        self.picker = Picker(document.mesh)
        self.view = FaceView(ctx, self.model)
        self._deformer = deformer
        self._builds: LatestTaskWorker[tuple[FaceModel, float]] = LatestTaskWorker()
        self._muscles: MuscleDeformer | None = None
        self._muscle_builds: LatestTaskWorker[MuscleDeformer] = LatestTaskWorker()
        self._contracted: tuple[Mapping[str, float], float, NDArray[np.float32]] | None = None

    @property
    def busy(self) -> bool:
        """Whether an operator is being built."""
        return self._builds.busy

    def update(self, deformer: DeformerOptions, muscles: MuscleState) -> None:
        """Start the builds that the settings need, and use those that have ended. Raises what a build raised."""
        builder = self._builder
        if builder is None:
            return
        if deformer != self._deformer:
            self._deformer = deformer
            self._builds.submit(lambda: _build(builder, deformer))
        built = self._builds.poll()
        if built is not None:
            self.model, self.build_ms = built
            self.view.face = self.model
        if muscles.active and self._muscles is None and not self._muscle_builds.busy:
            model = self.model
            self._muscle_builds.submit(lambda: MuscleDeformer(model))
        self._muscles = self._muscle_builds.poll() or self._muscles

    def muscle_vertices(self, muscles: MuscleState) -> NDArray[np.float32]:
        """Return the (V, 3) vertices as deformed by the muscles; neutral while these are being built."""
        if self._muscles is None:
            return self.model.neutral
        if self._contracted is None or self._contracted[:2] != (muscles.contractions, muscles.jaw):
            vertices = self._muscles.deform(muscles.contractions, jaw=muscles.jaw)
            self._contracted = (muscles.contractions, muscles.jaw, vertices)
        return self._contracted[2]

    def release(self) -> None:
        """Wait for the running builds, free all GPU objects."""
        self._builds.close()
        self._muscle_builds.close()
        self.view.release()


def face_without_points(document: FaceDocument) -> FaceModel:
    """Return a model that can be drawn but does not move, for a face without control points."""
    points = read_ppc(DEFAULT_HEAD.with_suffix(".ppc"))
    operator = np.zeros((len(document.mesh.vertices), CONTROL_POINT_COUNT), np.float32)
    return FaceModel(document.mesh, points, operator, file_to_model=document.file_to_model)


def _build(builder: OperatorBuilder, deformer: DeformerOptions) -> tuple[FaceModel, float]:
    start = time.perf_counter()
    model = builder.build_face(deformer)
    return model, 1e3 * (time.perf_counter() - start)
