from dataclasses import replace

import numpy as np

from conf.animator.face_document import Subject
from conf.animator.face_instance import Actor, unplaced
from conf.animator.state.muscles import Muscling
from conf.face.deformation.face_model import Deformer
from tests.support.imgui_stage import Stage


def test_an_operator_is_built_behind_the_picture_and_muscles_attach(stage: Stage, subject: Subject) -> None:
    actor = Actor(stage.window.ctx, subject, Deformer())
    before = actor.face
    wanted = Deformer("linear")
    actor.follow(wanted, Muscling())
    assert actor.busy
    while actor.busy:
        actor.follow(wanted, Muscling())
    assert actor.face is not before and actor.face.mesh is before.mesh
    smile = Muscling().posed("smile")
    while (vertices := actor.by_muscles(smile)) is None:
        actor.follow(wanted, smile)
    assert 0.3 < np.abs(vertices - actor.face.neutral).max() < 3.0
    assert actor.by_muscles(smile) is vertices, "what has not changed is not computed again"
    actor.release()


def test_a_face_without_points_stands_still(subject: Subject) -> None:
    face = unplaced(replace(subject, points=None))
    np.testing.assert_array_equal(face.deform(np.full((50, 3), 100.0)), face.neutral)
