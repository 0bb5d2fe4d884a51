import numpy as np

from conf.face.deformation.face_model import FaceModel
from conf.render.auto_framing import FrameArea, rest_pose
from conf.render.camera import ViewState
from conf.render.render_target import RenderTarget
from conf.render.vertex_colour_renderer import VertexColourRenderer
from conf.render.window.offscreen import OffscreenWindow


def test_the_face_is_drawn_in_the_vertex_colours(window: OffscreenWindow, face: FaceModel) -> None:
    renderer, target = VertexColourRenderer(window.ctx, face.mesh), RenderTarget(window.ctx, window.size)
    centres = []
    for colour in ([1.0, 0.0, 0.0], [0.0, 0.0, 1.0]):
        renderer.set_colours(np.tile(np.array(colour, np.float32), (len(face.neutral), 1)))
        window.begin()
        target.begin()
        renderer.draw(face.neutral, rest_pose(FrameArea()), ViewState(), target)
        target.resolve(window.framebuffer)
        centres.append(window.read()[120, 160].astype(int))
    red, blue = centres
    assert red[2] > 90 and red[0] < 10 and blue[0] > 90 and blue[2] < 10
    renderer.release()
    target.release()
