import numpy as np
import pytest

from conf.receiver.portrait.layer import TexturedLayer, load_texture
from conf.render.shader_programs import load_program
from conf.render.window.offscreen import OffscreenWindow


@pytest.mark.usefixtures("gl")
def test_the_first_row_of_a_texture_is_drawn_at_the_top() -> None:
    pixels = np.zeros((2, 1, 3), np.uint8)
    pixels[0], pixels[1] = (255, 0, 0), (0, 0, 255)  # blue above red
    with OffscreenWindow(8, 8) as window:
        window.begin()
        program = load_program(window.ctx, "portrait", "portrait")
        program["frame"], program["opacity"], program["fade"] = (1.0, 1.0, 0.0, 0.0), 1.0, 0.0
        corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]], np.float32)
        layer = TexturedLayer(
            window.ctx, program, window.ctx.buffer(corners.tobytes()), uvs=corners * (0.5, -0.5) + 0.5,
            alphas=np.ones(4), triangles=np.array([[0, 1, 2], [0, 2, 3]]), texture=load_texture(window.ctx, pixels),
        )  # fmt: skip
        layer.draw()
        image = window.read()
        layer.release()
    np.testing.assert_array_equal(image[0, 4], (255, 0, 0))
    np.testing.assert_array_equal(image[-1, 4], (0, 0, 255))
