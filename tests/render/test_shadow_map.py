import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from conf.face.deformation.face_model import FaceModel
from conf.render.lighting import STUDIO
from conf.render.shader_programs import load_source
from conf.render.shadow_map import EXTENT_CM, MAX_MAPS, SIZE, ShadowMap, light_matrix
from conf.render.vertex_normals import VertexNormals
from conf.render.window.offscreen import OffscreenWindow

KEY = np.array(STUDIO.key)
angle = st.floats(-3.0, 3.0)


@pytest.mark.slow
@given(angle, angle, angle)
def test_the_light_matrix_looks_along_the_key_light_without_distortion(x: float, y: float, z: float) -> None:
    rotation = Rotation.from_euler("XYZ", [x, y, z]).as_matrix()
    matrix = light_matrix(rotation)
    towards_light = rotation.T @ KEY / np.linalg.norm(KEY) * EXTENT_CM
    np.testing.assert_allclose(matrix[:3, :3] @ towards_light, [0.0, 0.0, -1.0], atol=1e-12)
    np.testing.assert_allclose(matrix[:3, :3] @ matrix[:3, :3].T * EXTENT_CM**2, np.eye(3), atol=1e-12)


def test_the_default_direction_is_that_of_the_shaders() -> None:
    numbers = load_source("lighting.glsl").split("const vec3 KEY = normalize(vec3(")[1].split(")")[0]
    assert [float(number) for number in numbers.split(",")] == pytest.approx(KEY.tolist())


def test_the_map_holds_the_depth_of_the_nearest_surface(window: OffscreenWindow, face: FaceModel) -> None:
    rows = VertexNormals(face.mesh.triangles, face.mesh.render_vertices).interleaved(face.neutral)
    shadow = ShadowMap(window.ctx, face.mesh, window.ctx.buffer(rows.tobytes()))
    light = light_matrix(np.eye(3))
    shadow.update(light, face.control_points.astype(np.float32))
    depth = np.frombuffer(shadow.depth.read(), np.float32).reshape(SIZE, SIZE)
    shadow.release()
    casters = face.mesh.vertices[face.mesh.group_vertices("skin", "hair")]
    nearest = ((casters @ light[:3, :3].T)[:, 2].min() + 1) / 2
    assert depth.min() == pytest.approx(nearest, abs=0.01)
    assert depth[0, 0] == 1.0


def test_the_map_is_redrawn_only_when_the_face_rotates_or_moves(window: OffscreenWindow, face: FaceModel) -> None:
    rows = VertexNormals(face.mesh.triangles, face.mesh.render_vertices).interleaved(face.neutral)
    shadow = ShadowMap(window.ctx, face.mesh, window.ctx.buffer(rows.tobytes()))
    points = face.control_points.astype(np.float32)
    first = shadow.update(light_matrix(np.eye(3)), points)
    for angle, lift, is_redrawn in [(0.01, 0.0, False), (0.0, 0.05, False), (0.05, 0.0, True), (0.05, 0.1, True)]:
        light = light_matrix(Rotation.from_euler("Y", angle).as_matrix())
        drawn = shadow.update(light, points + np.float32(lift))
        np.testing.assert_array_equal(drawn, light if is_redrawn else first)
    shadow.release()


def test_each_participant_has_a_map_and_the_one_drawn_longest_ago_is_replaced(
    window: OffscreenWindow, face: FaceModel
) -> None:
    rows = VertexNormals(face.mesh.triangles, face.mesh.render_vertices).interleaved(face.neutral)
    shadow = ShadowMap(window.ctx, face.mesh, window.ctx.buffer(rows.tobytes()))
    points = face.control_points.astype(np.float32)
    lights = [light_matrix(Rotation.from_euler("Y", 0.1 * i).as_matrix()) for i in range(MAX_MAPS + 2)]
    nearly = light_matrix(Rotation.from_euler("Y", 0.11).as_matrix())
    for participant in (1, 2):
        shadow.update(lights[participant], points, participant=participant)
    maps = [shadow.depth.glo]
    np.testing.assert_array_equal(shadow.update(nearly, points, participant=1), lights[1])
    maps.append(shadow.depth.glo)
    assert maps[0] != maps[1]
    for participant in range(2, MAX_MAPS + 2):
        shadow.update(lights[participant], points, participant=participant)
    np.testing.assert_array_equal(shadow.update(nearly, points, participant=1), nearly)
    shadow.release()
