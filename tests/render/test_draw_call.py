import moderngl
import numpy as np

from conf.render.draw_call import DrawCall
from conf.render.shader_programs import to_column_major
from conf.render.window.offscreen import OffscreenWindow
from tests.support.image_measures import box

CORNERS = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], np.float32)


def test_triangles_are_drawn_with_the_matrices_given_and_unused_attributes_are_skipped(window: OffscreenWindow) -> None:
    rows = np.hstack([CORNERS, np.tile(np.float32([0, 0, 1]), (4, 1)), np.ones((4, 2), np.float32)])
    attributes = [(window.ctx.buffer(rows.tobytes()), "3f4 3f4 2f4", "in_position", "in_normal", "in_unknown")]
    matrices = {"clip": np.diag([0.5, 0.5, 1.0, 1.0]), "rotation": np.eye(3), "unused": np.eye(4)}
    with DrawCall(window.ctx, ("face", "wireframe"), attributes, np.array([[0, 1, 2], [0, 2, 3]])) as draw_call:
        window.begin()
        window.ctx.enable_only(moderngl.NOTHING)
        draw_call.program["tint"] = (1.0, 0.0, 0.0)
        draw_call.draw(**{name: to_column_major(matrix) for name, matrix in matrices.items()})
    assert box(window.read().any(axis=2)) == (80, 60, 240, 180)
    assert window.read()[120, 160].tolist() == [0, 0, 255]
