from dataclasses import replace

import numpy as np

from conf.animator.face_document import FaceDocument
from conf.animator.face_instance import FaceInstance, face_without_points
from conf.animator.state.muscles import MuscleState
from conf.face.deformation.face_model import DeformerOptions
from tests.support.imgui_stage import Stage


def test_an_operator_is_built_behind_the_picture_and_muscles_attach(stage: Stage, subject: FaceDocument) -> None:
    actor = FaceInstance(stage.window.ctx, subject, DeformerOptions())
    before = actor.face
    wanted = DeformerOptions("linear")
    actor.update(wanted, MuscleState())
    assert actor.busy
    while actor.busy:
        actor.update(wanted, MuscleState())
    assert actor.face is not before and actor.face.mesh is before.mesh
    smile = MuscleState().with_preset("smile")
    while (vertices := actor.muscle_vertices(smile)) is None:
        actor.update(wanted, smile)
    assert 0.3 < np.abs(vertices - actor.face.neutral).max() < 3.0
    assert actor.muscle_vertices(smile) is vertices, "what has not changed is not computed again"
    actor.release()


def test_a_face_without_points_stands_still(subject: FaceDocument) -> None:
    face = face_without_points(replace(subject, points=None))
    np.testing.assert_array_equal(face.deform(np.full((50, 3), 100.0)), face.neutral)
