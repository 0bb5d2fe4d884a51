from dataclasses import replace

import numpy as np
import pytest

from conf.animator.builder import FaceBuilder
from conf.animator.face_document import FaceDocument
from conf.face.deformation.face_model import DeformerOptions, FaceModel, build_face
from conf.face.deformation.kernels import KERNELS


@pytest.mark.parametrize(
    "deformer",
    [
        DeformerOptions(),
        DeformerOptions("linear", epsilon=0.5, degree=1, smoothing=0.1),
        DeformerOptions(use_regions=False, use_ridge_refinement=False),
    ],
)
def test_it_builds_what_make_face_builds(subject: FaceDocument, deformer: DeformerOptions) -> None:
    assert subject.points is not None
    slow = build_face(subject.mesh, subject.points, deformer, rig=subject.rig, shapes=subject.shapes)
    quick = FaceBuilder(subject).build(deformer)
    np.testing.assert_allclose(quick.operator, slow.operator, atol=1e-6)
    assert quick.smoothing == pytest.approx(slow.smoothing)


def test_every_kernel_can_be_had_and_none_moves_a_face_at_rest(subject: FaceDocument, head: FaceModel) -> None:
    builder = FaceBuilder(subject)
    for kernel in KERNELS:
        face = builder.build(DeformerOptions(kernel))
        assert np.isfinite(face.operator).all()
        np.testing.assert_allclose(face.deform(np.zeros((50, 3))), head.neutral, atol=1e-5)


def test_a_singular_system_is_met_with_lambda(subject: FaceDocument) -> None:
    face = FaceBuilder(subject).build(DeformerOptions("gaussian", epsilon=0.05, smoothing=0.0))
    assert face.smoothing > 0
    assert np.isfinite(face.operator).all()


def test_what_is_not_there_is_said(subject: FaceDocument) -> None:
    with pytest.raises(ValueError, match="subject must have control points"):
        FaceBuilder(replace(subject, points=None))
    with pytest.raises(ValueError, match="kernel must be one of"):
        FaceBuilder(subject).build(DeformerOptions("cubic"))
