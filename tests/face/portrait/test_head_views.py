import numpy as np
import pytest

from conf.face.control_points import CONTROL_POINT_COUNT, control_point_indices
from conf.face.head_pose import HeadPose
from conf.face.portrait.contours import OVAL_ROWS
from conf.face.portrait.head_views import HeadView, describe_shape, view_alpha, view_weights
from conf.face.portrait.warp import PortraitWarp
from tests.support.synthetic_portrait import POSE, face_points, face_shape

POINTS = face_points()[:CONTROL_POINT_COUNT]
TURNED = HeadPose(np.array([0.05, 0.3, 0.08]), POSE.position, POSE.log_scale)


def test_a_descriptor_ignores_position_and_size_and_measures_turns_and_expressions() -> None:
    moved = HeadPose(POSE.rotation, POSE.position + 0.2, POSE.log_scale + 0.3)
    still = describe_shape(POINTS, POSE)
    np.testing.assert_allclose(describe_shape(POINTS, moved), still, atol=1e-12)
    opened = POINTS.copy()
    opened[control_point_indices("inner_lip_lower"), 1] -= 1.0
    for other in (describe_shape(POINTS, TURNED), describe_shape(opened, POSE)):
        assert np.linalg.norm(other - still) / np.sqrt(CONTROL_POINT_COUNT) > 0.1


def test_photo_and_views_are_weighted_by_their_distance() -> None:
    shapes = np.array([describe_shape(POINTS, pose) for pose in (POSE, TURNED)])
    weights = view_weights(np.array([*shapes, shapes.mean(axis=0)]), shapes)
    np.testing.assert_allclose(weights.sum(axis=1), 1)
    assert weights[0, 0] > 0.95 and weights[1, 1] > 0.95
    np.testing.assert_allclose(weights[2], 0.5)
    np.testing.assert_allclose(view_weights(shapes[0], shapes), weights[0])


@pytest.mark.slow
def test_a_view_of_the_photos_own_pose_is_the_photo() -> None:
    warp = PortraitWarp(face_shape())
    head = HeadView.of_points(warp, POINTS, POSE)
    np.testing.assert_allclose(head.positions[warp.on_face], warp.mesh.positions[warp.on_face], atol=2e-3)


@pytest.mark.slow
def test_a_view_shows_where_the_mesh_is_drawn_for_the_same_motion() -> None:
    warp = PortraitWarp(face_shape())
    drawn = warp.deform(np.zeros((CONTROL_POINT_COUNT, 3)), TURNED)
    view = HeadView.of_points(warp, warp.control_points(np.zeros((CONTROL_POINT_COUNT, 3))), TURNED)
    np.testing.assert_allclose(view.positions[warp.on_face], drawn[warp.on_face], atol=2e-3)


@pytest.mark.slow
def test_views_are_opaque_on_the_face_and_transparent_beyond_its_oval() -> None:
    warp = PortraitWarp(face_shape())
    alpha = view_alpha(warp)
    assert alpha[:CONTROL_POINT_COUNT].min() > 0.3 and alpha[control_point_indices("inner_lip")].min() == 1
    centre = warp.positions_cm[OVAL_ROWS].mean(axis=0)
    far = np.linalg.norm(warp.positions_cm - centre, axis=1) > 1.3 * np.ptp(warp.positions_cm[OVAL_ROWS, 1]) / 2
    assert far.any() and alpha[far].max() == 0
