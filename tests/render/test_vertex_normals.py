import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from conf.render.vertex_normals import VertexNormals
from tests.support.stand_in_head import ball, ball_triangles

VERTICES, TRIANGLES = ball(np.zeros(3), 2.0, 32).astype(np.float32), ball_triangles(32)


def test_the_normals_of_a_ball_are_along_its_radii() -> None:
    normals = VertexNormals(TRIANGLES, np.arange(len(VERTICES))).normals(VERTICES)
    inner = np.abs(VERTICES[:, 1]) < 1.9  # the poles are many vertices at one position
    unit = normals[inner] / np.linalg.norm(normals[inner], axis=1, keepdims=True)
    np.testing.assert_allclose(unit, VERTICES[inner] / 2.0, atol=0.02)


@pytest.mark.slow
@given(
    hnp.arrays(np.float32, (7, 3), elements=st.floats(-10, 10, width=32)),
    hnp.arrays(np.int32, st.tuples(st.integers(1, 12), st.just(3)), elements=st.integers(0, 6)),
)
def test_normals_are_the_sums_of_the_faces_cross_products(vertices: np.ndarray, triangles: np.ndarray) -> None:
    expected = np.zeros((7, 3))
    a, b, c = (vertices[triangles[:, i]].astype(np.float64) for i in range(3))
    for corner in range(3):
        np.add.at(expected, triangles[:, corner], np.cross(b - a, c - a))
    normals = VertexNormals(triangles, np.arange(7))
    np.testing.assert_allclose(normals.normals(vertices), expected, atol=1e-2)


def test_all_render_vertices_of_a_vertex_have_its_normal() -> None:
    render_vertices = np.concatenate([np.arange(len(VERTICES)), np.arange(40, 80)])
    rows = VertexNormals(TRIANGLES, render_vertices).interleaved(VERTICES)
    np.testing.assert_array_equal(rows[-40:], rows[40:80])
    np.testing.assert_array_equal(rows[:, :3], VERTICES[render_vertices])


def test_unused_vertices_have_a_zero_normal() -> None:
    normals = VertexNormals(np.array([[0, 1, 2]]), np.arange(5))
    np.testing.assert_array_equal(normals.interleaved(np.eye(5, 3, dtype=np.float32))[3:, 3:], 0)
