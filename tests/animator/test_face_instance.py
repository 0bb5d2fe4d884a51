from dataclasses import replace

import numpy as np
import pytest

from conf.animator.face_document import FaceDocument
from conf.animator.face_instance import FaceInstance, face_without_points
from conf.animator.state.editor import MuscleState
from conf.face.deformation.face_model import DeformerOptions
from tests.support.imgui_stage import Stage


@pytest.mark.slow
def test_operator_and_muscles_are_built_in_the_background(stage: Stage, document: FaceDocument) -> None:
    face = FaceInstance(stage.window.ctx, document, DeformerOptions())
    before = face.model
    options = DeformerOptions("linear")
    face.update(options, MuscleState())
    assert face.busy
    while face.busy:
        face.update(options, MuscleState())
    assert face.model is not before and face.model.mesh is before.mesh and face.build_ms > 0
    smile = MuscleState().with_preset("smile")
    assert face.muscle_vertices(smile) is face.model.neutral
    while (vertices := face.muscle_vertices(smile)) is face.model.neutral:
        face.update(options, smile)
    assert 0.3 < np.abs(vertices - face.model.neutral).max() < 3.0
    assert face.muscle_vertices(smile) is vertices, "unchanged contractions are not computed again"
    face.release()


def test_a_face_without_points_does_not_move(document: FaceDocument) -> None:
    model = face_without_points(replace(document, points=None))
    np.testing.assert_array_equal(model.deform(np.full((50, 3), 100.0)), model.neutral)
