import numpy as np
import pytest

from conf.face.deformation.face_model import FaceModel
from conf.render.auto_framing import FrameArea, rest_pose
from conf.render.camera import ViewState
from conf.render.face_renderer import FaceRenderer
from conf.render.window.offscreen import OffscreenWindow


@pytest.mark.slow
def test_the_face_is_drawn_in_the_vertex_colours(window: OffscreenWindow, face: FaceModel) -> None:
    images = []
    with FaceRenderer(window.ctx, face) as renderer:
        for colour in (None, [1.0, 0.0, 0.0], [0.0, 0.0, 1.0], None):
            renderer.set_colours(
                None if colour is None else np.tile(np.array(colour, np.float32), (len(face.neutral), 1))
            )
            window.begin()
            renderer.draw(face.neutral, rest_pose(FrameArea()), ViewState(), window.framebuffer)
            images.append(window.read())
    red, blue = (image[120, 160].astype(int) for image in images[1:3])
    assert red[2] > 90 and red[0] < 10 and blue[0] > 90 and blue[2] < 10
    np.testing.assert_array_equal(images[0], images[3])
