from typing import get_args

from conf.animator import commands as requests
from conf.animator.controller import Director
from conf.animator.face_document import Subject
from conf.animator.face_instance import Actor
from conf.face.deformation.face_model import Deformer
from tests.support.imgui_stage import Stage


def test_the_director_can_carry_out_every_request(stage: Stage, subject: Subject) -> None:
    director = Director(stage.window.ctx, Actor(stage.window.ctx, subject, Deformer()))
    assert set(director._handlers) == set(get_args(requests.Request))
    director.release()
