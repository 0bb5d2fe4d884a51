import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from conf.face.deformation.face_model import FaceModel
from conf.render.shader_programs import load_source, to_column_major
from conf.render.shadow_map import EXTENT_CM, KEY, SIZE, ShadowMap, light_matrix
from conf.render.vertex_normals import VertexNormals
from conf.render.window.offscreen import OffscreenWindow

angle = st.floats(-3.0, 3.0)


@given(angle, angle, angle)
def test_the_lamp_sees_the_head_whole_from_its_side_whichever_way_it_turns(x: float, y: float, z: float) -> None:
    turn = Rotation.from_euler("XYZ", [x, y, z]).as_matrix()
    matrix = light_matrix(turn)
    towards_lamp = turn.T @ KEY / np.linalg.norm(KEY) * EXTENT_CM
    np.testing.assert_allclose(matrix[:3, :3] @ towards_lamp, [0.0, 0.0, -1.0], atol=1e-12)
    np.testing.assert_allclose(matrix[:3, :3] @ matrix[:3, :3].T * EXTENT_CM**2, np.eye(3), atol=1e-12)


def test_the_lamp_hangs_where_the_shaders_light_comes_from() -> None:
    numbers = load_source("lighting.glsl").split("const vec3 KEY = normalize(vec3(")[1].split(")")[0]
    assert [float(number) for number in numbers.split(",")] == pytest.approx(KEY.tolist())


def test_the_lamps_picture_holds_the_nearest_depth(window: OffscreenWindow, face: FaceModel) -> None:
    rows = VertexNormals(face.mesh.triangles, face.mesh.render_vertices).interleaved(face.neutral)
    shadow = ShadowMap(window.ctx, face.mesh, window.ctx.buffer(rows.tobytes()))
    lamp = light_matrix(np.eye(3))
    shadow.draw(to_column_major(lamp))
    depth = np.frombuffer(shadow.depth.read(), np.float32).reshape(SIZE, SIZE)
    shadow.release()
    casts = face.mesh.vertices[face.mesh.group_vertices("skin", "hair")]
    nearest = ((casts @ lamp[:3, :3].T)[:, 2].min() + 1) / 2
    assert depth.min() == pytest.approx(nearest, abs=0.01)
    assert depth[0, 0] == 1.0


def test_a_new_picture_is_taken_when_the_face_turns_or_moves_and_only_then(
    window: OffscreenWindow, face: FaceModel
) -> None:
    rows = VertexNormals(face.mesh.triangles, face.mesh.render_vertices).interleaved(face.neutral)
    shadow = ShadowMap(window.ctx, face.mesh, window.ctx.buffer(rows.tobytes()))
    places = face.control_points.astype(np.float32)
    first = shadow.update(light_matrix(np.eye(3)), places)
    for angle, lift, is_new in [(0.01, 0.0, False), (0.0, 0.05, False), (0.05, 0.0, True), (0.05, 0.1, True)]:
        lamp = light_matrix(Rotation.from_euler("Y", angle).as_matrix())
        taken = shadow.update(lamp, places + np.float32(lift))
        np.testing.assert_array_equal(taken, lamp if is_new else first)
    shadow.release()
