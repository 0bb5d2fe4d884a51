import moderngl
import numpy as np
import pytest

from conf.render.shader_programs import load_program, load_source, set_matrix, to_column_major
from conf.render.window.offscreen import OffscreenWindow

PAIRS = [
    ("face_shadowed", "skin"), ("face_shadowed", "cloth"),
    ("face", "eye"), ("face", "mouth"), ("face", "hair"), ("face", "wireframe"),
    ("markers", "markers"), ("depth_only", "depth_only"), ("fullscreen", "compose"), ("fullscreen", "antialias"),
    ("imgui", "imgui"), ("vertex_colour", "vertex_colour"), ("portrait", "portrait"), ("portrait", "portrait_mouth"),
]  # fmt: skip


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
    assert program["light"].value == tuple(matrix.T.ravel())
