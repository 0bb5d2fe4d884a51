import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.animator.face_document import FaceDocument
from conf.animator.motion_player import REST_POSE
from conf.animator.picking import Picker, Rect, nearest_point
from conf.face.control_points import CONTROL_POINT_INDEX
from conf.render.camera import ViewState, clip_matrix

RECT = Rect(100, 20, 700, 500)
SEEN = [
    "chin_boss",
    "brow_top_l",
    "brow_top_r",
    "cheek_center_l",
    "outer_lip_upper_mid",
    "pupil_r",
    "nose_bottom_edge_l",
]


@pytest.fixture(scope="module")
def picker(subject: FaceDocument) -> Picker:
    return Picker(subject.mesh)


@pytest.mark.parametrize("name", SEEN)
@pytest.mark.parametrize("view", [ViewState(), ViewState(yaw=0.2, pitch=-0.1, zoom=1.7, pan=(0.1, -0.05))])
def test_what_lies_under_a_points_pixel_is_the_point(
    picker: Picker, subject: FaceDocument, name: str, view: ViewState
) -> None:
    assert subject.points is not None
    clip = clip_matrix(REST_POSE, view, aspect=RECT.width / RECT.height)
    point = subject.points[CONTROL_POINT_INDEX[name]]
    x, y = RECT.to_pixels(point[None], clip)[0]
    hit = picker.pick(RECT.to_ndc(x, y), clip)
    assert hit is not None
    assert np.linalg.norm(hit - point) < 0.12


def test_beside_the_face_there_is_nothing(picker: Picker) -> None:
    clip = clip_matrix(REST_POSE, ViewState(), aspect=RECT.width / RECT.height)
    assert picker.pick(RECT.to_ndc(RECT.x + 3, RECT.y + 3), clip) is None


@pytest.mark.parametrize("name", SEEN)
def test_the_mirrored_place_lies_where_the_partner_is(picker: Picker, subject: FaceDocument, name: str) -> None:
    assert subject.points is not None
    point = subject.points[CONTROL_POINT_INDEX[name]]
    mirrored = picker.project_to_surface(point * [-1.0, 1.0, 1.0])
    assert np.linalg.norm(mirrored - point * [-1.0, 1.0, 1.0]) < 0.15


def test_a_place_far_from_the_mesh_comes_to_a_vertex(picker: Picker, subject: FaceDocument) -> None:
    place = picker.project_to_surface(np.array([0.0, 0.0, 60.0]))
    assert np.isclose(subject.mesh.vertices, place).all(axis=1).any()


@given(st.floats(100, 799), st.floats(20, 519))
def test_pixels_and_ndc_are_the_same_place(x: float, y: float) -> None:
    assert RECT.contains(x, y)
    ndc = RECT.to_ndc(x, y)
    flat = np.diag([1.0, 1.0, 1.0, 1.0])
    np.testing.assert_allclose(RECT.to_pixels(np.array([[*ndc, 0.0]]), flat)[0], [x, y], atol=1e-9)


def test_the_nearest_mark_within_reach() -> None:
    marks = np.array([[10.0, 10.0], [np.nan, np.nan], [14.0, 10.0]])
    assert nearest_point(13, 10, marks, reach=5) == 2
    assert nearest_point(30, 10, marks, reach=5) is None
