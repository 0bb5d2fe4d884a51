import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.animator.face_document import FaceDocument
from conf.animator.motion_player import REST_POSE
from conf.animator.picking import Picker, nearest_point
from conf.face.control_points import CONTROL_POINT_INDEX
from conf.render.camera import ViewState, clip_matrix
from conf.render.ui.rectangle import Rect

RECT = Rect(100, 20, 700, 500)
FRONT_POINTS = [
    *("chin_boss", "brow_top_l", "brow_top_r", "cheek_center_l", "outer_lip_upper_mid", "pupil_r"),
    "nose_bottom_edge_l",
]


@pytest.fixture(scope="module")
def picker(document: FaceDocument) -> Picker:
    return Picker(document.mesh)


@pytest.mark.parametrize("name", FRONT_POINTS)
@pytest.mark.parametrize("camera", [ViewState(), ViewState(yaw=0.2, pitch=-0.1, zoom=1.7, pan=(0.1, -0.05))])
def test_picking_a_points_pixel_returns_the_point(
    picker: Picker, points: np.ndarray, name: str, camera: ViewState
) -> None:
    clip = clip_matrix(REST_POSE, camera, aspect=RECT.width / RECT.height)
    point = points[CONTROL_POINT_INDEX[name]]
    x, y = RECT.to_pixels(point[None], clip)[0]
    hit = picker.pick(RECT.to_ndc(x, y), clip)
    assert hit is not None
    assert np.linalg.norm(hit - point) < 0.12


def test_beside_the_face_nothing_is_picked(picker: Picker) -> None:
    clip = clip_matrix(REST_POSE, ViewState(), aspect=RECT.width / RECT.height)
    assert picker.pick(RECT.to_ndc(RECT.x + 3, RECT.y + 3), clip) is None


@pytest.mark.parametrize("name", FRONT_POINTS)
def test_a_mirrored_point_is_projected_to_its_partner(picker: Picker, points: np.ndarray, name: str) -> None:
    mirrored = points[CONTROL_POINT_INDEX[name]] * [-1.0, 1.0, 1.0]
    assert np.linalg.norm(picker.project_to_surface(mirrored) - mirrored) < 0.15


def test_a_position_far_from_the_mesh_is_projected_to_a_vertex(picker: Picker, document: FaceDocument) -> None:
    position = picker.project_to_surface(np.array([0.0, 0.0, 60.0]))
    assert np.isclose(document.mesh.vertices, position).all(axis=1).any()


@given(st.floats(100, 799), st.floats(20, 519))
def test_pixels_and_device_coordinates_are_inverse(x: float, y: float) -> None:
    assert RECT.contains(x, y)
    ndc = RECT.to_ndc(x, y)
    np.testing.assert_allclose(RECT.to_pixels(np.array([[*ndc, 0.0]]), np.eye(4))[0], [x, y], atol=1e-9)


def test_the_nearest_point_within_the_radius_is_found() -> None:
    points = np.array([[10.0, 10.0], [np.nan, np.nan], [14.0, 10.0]])
    assert nearest_point(13, 10, points, radius=5) == 2
    assert nearest_point(30, 10, points, radius=5) is None
