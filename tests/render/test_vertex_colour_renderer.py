import numpy as np

from conf.animator.motion_player import REST_POSE
from conf.face.deformation.face_model import FaceModel
from conf.render.camera import ViewState
from conf.render.render_target import RenderTarget
from conf.render.vertex_colour_renderer import VertexColourRenderer
from conf.render.window.offscreen import OffscreenWindow


def test_the_face_has_the_colours_it_was_given(window: OffscreenWindow, face: FaceModel) -> None:
    tinted, canvas = VertexColourRenderer(window.ctx, face.mesh), RenderTarget(window.ctx, window.size)
    middles = []
    for colour in ([1.0, 0.0, 0.0], [0.0, 0.0, 1.0]):
        tinted.colour(np.tile(np.array(colour, np.float32), (len(face.neutral), 1)))
        window.begin()
        canvas.begin()
        tinted.draw(face.neutral, REST_POSE, ViewState(), canvas)
        canvas.resolve(window.framebuffer)
        middles.append(window.read()[120, 160].astype(int))
    red, blue = middles
    assert red[2] > 90 and red[0] < 10 and blue[0] > 90 and blue[2] < 10
    tinted.release()
    canvas.release()
