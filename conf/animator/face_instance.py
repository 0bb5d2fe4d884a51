"""The face on the stage: its model, what draws it, and the worker that builds its next operator meanwhile."""

import time
from collections.abc import Mapping
from dataclasses import dataclass

import moderngl
import numpy as np
from numpy.typing import NDArray

from conf.animator.background_task import LatestTaskWorker
from conf.animator.face_document import FaceDocument
from conf.animator.face_view import FaceView
from conf.animator.picking import Picker
from conf.animator.state.muscles import MuscleState
from conf.face.control_points import CONTROL_POINT_COUNT
from conf.face.default_head import DEFAULT_HEAD
from conf.face.deformation.face_model import DeformerOptions, FaceModel
from conf.face.deformation.facial_muscles import MuscleDeformer
from conf.face.deformation.operator_builder import OperatorBuilder
from conf.face.fapu import Fapu
from conf.face.formats.ppc import read_ppc


@dataclass(frozen=True)
class BuiltFace:
    """A face as one deformer moves it, and the milliseconds it took."""

    face: FaceModel
    milliseconds: float


class FaceInstance:
    """One subject, drawn and moved."""

    def __init__(self, ctx: moderngl.Context, subject: FaceDocument, deformer: DeformerOptions) -> None:
        self.subject = subject
        self._builder = None if subject.points is None else subject.operator_builder()
        self.built = (
            BuiltFace(face_without_points(subject), 0.0) if self._builder is None else _build(self._builder, deformer)
        )
        self.picker = Picker(subject.mesh)
        self._deformer = deformer
        self._picture = FaceView(ctx, self.built.face)
        self._operators: LatestTaskWorker[BuiltFace] = LatestTaskWorker()
        self._muscles: MuscleDeformer | None = None
        self._attaching: LatestTaskWorker[MuscleDeformer] = LatestTaskWorker()
        self._contracted: tuple[Mapping[str, float], float, NDArray[np.float32]] | None = None

    @property
    def face(self) -> FaceModel:
        """The face as it is moved now."""
        return self.built.face

    @property
    def picture(self) -> FaceView:
        """What draws it."""
        return self._picture

    @property
    def busy(self) -> bool:
        """Whether an operator is being built."""
        return self._operators.busy

    def update(self, deformer: DeformerOptions, muscling: MuscleState) -> None:
        """Build what the desk asks for in the background, and take what is ready. Raises what building raised."""
        if self._builder is None:
            return
        if deformer != self._deformer:
            self._deformer = deformer
            builder = self._builder
            self._operators.submit(lambda: _build(builder, deformer))
        built = self._operators.poll()
        if built is not None:
            self.built = built
            self._picture.set_face(built.face)
        if muscling.active and self._muscles is None and not self._attaching.busy:
            face = self.face
            self._attaching.submit(lambda: MuscleDeformer(face))
        self._muscles = self._attaching.poll() or self._muscles

    def muscle_vertices(self, muscling: MuscleState) -> NDArray[np.float32] | None:
        """Return the (V, 3) vertices as the muscles pull them, None while these are not attached yet."""
        if self._muscles is None:
            return None
        if self._contracted is None or self._contracted[:2] != (muscling.contractions, muscling.jaw):
            vertices = self._muscles.deform(muscling.contractions, jaw=muscling.jaw)
            self._contracted = (muscling.contractions, muscling.jaw, vertices)
        return self._contracted[2]

    def release(self) -> None:
        """Free everything on the card, end the worker."""
        self._operators.close()
        self._attaching.close()
        self._picture.release()


def face_without_points(subject: FaceDocument) -> FaceModel:
    """Return a face that can be drawn and that nothing moves: its control points are not known."""
    points = read_ppc(DEFAULT_HEAD.with_suffix(".ppc"))
    operator = np.zeros((len(subject.mesh.vertices), CONTROL_POINT_COUNT), np.float32)
    return FaceModel(subject.mesh, points, Fapu.measure(points), operator, file_to_model=subject.placement)


def _build(builder: OperatorBuilder, deformer: DeformerOptions) -> BuiltFace:
    began = time.perf_counter()
    face = builder.build_face(deformer)
    return BuiltFace(face, 1e3 * (time.perf_counter() - began))
