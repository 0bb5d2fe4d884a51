from typing import get_args

from conf.animator import commands as requests
from conf.animator.controller import Controller
from conf.animator.face_document import FaceDocument
from conf.animator.face_instance import FaceInstance
from conf.face.deformation.face_model import DeformerOptions
from tests.support.imgui_stage import Stage


def test_the_director_can_carry_out_every_request(stage: Stage, subject: FaceDocument) -> None:
    director = Controller(stage.window.ctx, FaceInstance(stage.window.ctx, subject, DeformerOptions()))
    assert set(director._handlers) == set(get_args(requests.Request))
    director.release()
