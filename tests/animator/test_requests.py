from typing import get_args

from conf.animator import requests
from conf.animator.actor import Actor
from conf.animator.director import Director
from conf.animator.subject import Subject
from conf.face.deformation.face_model import Deformer
from tests.support.imgui_stage import Stage


def test_the_director_can_carry_out_every_request(stage: Stage, subject: Subject) -> None:
    director = Director(stage.window.ctx, Actor(stage.window.ctx, subject, Deformer()))
    assert set(director._handlers) == set(get_args(requests.Request))
    director.release()
