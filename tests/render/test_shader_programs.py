import moderngl
import numpy as np
import pytest

from conf.render.shader_programs import DrawCall, load_program, load_source, set_matrix, to_column_major
from conf.render.window.offscreen import OffscreenWindow
from tests.support.image_measures import box

PAIRS = [
    ("face_shadowed", "skin"), ("face_shadowed", "cloth"),
    ("face", "eye"), ("face", "mouth"), ("face", "hair"), ("face", "wireframe"),
    ("rectangles", "copy"), ("rectangles", "edges"), ("rectangles", "antialias"),
    ("markers", "markers"), ("depth_only", "depth_only"),
    ("imgui", "imgui"), ("vertex_colour", "vertex_colour"), ("portrait", "portrait"),
]  # fmt: skip
CORNERS = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], np.float32)


@pytest.mark.parametrize(("vertex", "fragment"), PAIRS)
def test_every_pair_of_shaders_compiles(window: OffscreenWindow, vertex: str, fragment: str) -> None:
    assert isinstance(load_program(window.ctx, vertex, fragment), moderngl.Program)


def test_includes_are_expanded() -> None:
    assert "#include" not in load_source("skin.frag.glsl")
    assert "vec3 to_linear" in load_source("skin.frag.glsl")


def test_matrices_are_set_column_by_column_and_unknown_ones_are_ignored(window: OffscreenWindow) -> None:
    program = load_program(window.ctx, "depth_only", "depth_only")
    matrix = np.arange(16.0).reshape(4, 4)
    set_matrix(program, "light", to_column_major(matrix))
    set_matrix(program, "unknown", to_column_major(matrix))
    uniform = program["light"]
    assert isinstance(uniform, moderngl.Uniform) and uniform.value == tuple(matrix.T.ravel())


def test_triangles_are_drawn_with_the_matrices_given_and_unused_attributes_are_skipped(window: OffscreenWindow) -> None:
    rows = np.hstack([CORNERS, np.tile(np.array([0, 0, 1], np.float32), (4, 1)), np.ones((4, 2), np.float32)])
    attributes = [(window.ctx.buffer(rows.tobytes()), "3f4 3f4 2f4", "in_position", "in_normal", "in_unknown")]
    matrices = {"clip": np.diag([0.5, 0.5, 1.0, 1.0]), "rotation": np.eye(3), "unused": np.eye(4)}
    with DrawCall(window.ctx, ("face", "wireframe"), attributes, np.array([[0, 1, 2], [0, 2, 3]])) as draw_call:
        window.begin()
        window.ctx.enable_only(moderngl.NOTHING)
        draw_call.program["tint"] = (1.0, 0.0, 0.0)
        draw_call.draw(**{name: to_column_major(matrix) for name, matrix in matrices.items()})
    assert box(window.read().any(axis=2)) == (80, 60, 240, 180)
    assert window.read()[120, 160].tolist() == [0, 0, 255]
