import numpy as np

from conf.animator.player import REST_POSE
from conf.animator.tinted import TintedFace
from conf.face.head import FaceModel
from conf.receiver.canvas import Canvas
from conf.receiver.scene import View
from tests.animator.conftest import Stage


def test_the_face_has_the_colours_it_was_given(stage: Stage, head: FaceModel) -> None:
    tinted, canvas = TintedFace(stage.window.ctx, head.mesh), Canvas(stage.window.ctx, stage.window.size)
    middles = []
    for colour in ([1.0, 0.0, 0.0], [0.0, 0.0, 1.0]):
        tinted.colour(np.tile(np.array(colour, np.float32), (len(head.neutral), 1)))
        stage.window.begin()
        canvas.begin()
        tinted.draw(head.neutral, REST_POSE, View(), canvas)
        canvas.show(stage.window.framebuffer)
        middles.append(stage.window.read()[450, 200].astype(int))
    red, blue = middles
    assert red[2] > 90 and red[0] < 10 and blue[0] > 90 and blue[2] < 10
    tinted.release()
    canvas.release()
