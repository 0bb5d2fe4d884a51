import numpy as np

from conf.face.control_points import CONTROL_POINT_INDEX
from conf.face.head_pose import HeadPose
from conf.face.portrait.photo_mesh import BORDER_EXTENSION, build_mesh
from conf.face.portrait.vertex_weights import SHOULDER_WEIGHT, border_alpha, head_weights
from tests.support.synthetic_portrait import POSE, face_shape

# A head so large and high that the upper border cuts off its crown.
LARGE = face_shape(HeadPose(POSE.rotation, np.array([0.1, 0.15]), float(np.log(0.04))))


def test_weights_of_head_shoulders_and_lower_border() -> None:
    face = face_shape()
    positions = build_mesh(face).positions
    weights = head_weights((positions - POSE.position) / np.exp(POSE.log_scale), positions, face)
    assert (weights >= 0).all() and (weights <= 1).all()
    above = (positions[:, 1] > 0.2) & (np.abs(positions[:, 0] - 0.03) < 0.2)
    np.testing.assert_allclose(weights[above], 1)
    assert weights[positions[:, 1] <= -0.5].max() == 0
    assert weights[np.abs(positions[:, 0]) > 0.72].max() <= SHOULDER_WEIGHT + 1e-9


def test_with_the_chin_at_the_border_the_neck_still_follows_the_head() -> None:
    face = face_shape(HeadPose(POSE.rotation, np.array([0.03, -0.18]), POSE.log_scale))
    positions = build_mesh(face).positions
    weights = head_weights((positions - face.pose.position) / np.exp(POSE.log_scale), positions, face)
    chin = positions[CONTROL_POINT_INDEX["chin_bottom"]]
    below = np.linalg.norm(positions - (chin[0], -0.5), axis=1) < 0.1
    assert chin[1] < -0.4 and weights[below & (positions[:, 1] > -0.51)].min() > 0.3


def test_the_crown_is_opaque_beyond_the_border_and_the_rest_is_not() -> None:
    pose = LARGE.pose
    positions = build_mesh(LARGE).positions
    alpha = border_alpha((positions - pose.position) / np.exp(pose.log_scale), positions, LARGE)
    assert (alpha >= 0).all() and (alpha <= 1).all()
    inside = (np.abs(positions) <= (LARGE.aspect / 2 + 1e-9, 0.5 + 1e-9)).all(axis=1)
    np.testing.assert_array_equal(alpha[inside], 1)
    above = ~inside & (positions[:, 1] > 0.5)
    over_face = np.abs(positions[:, 0] - pose.position[0]) < 0.1
    assert alpha[above & over_face].max() > 0.9
    assert alpha[above & (np.abs(positions[:, 0]) > 0.6)].max() == 0
    assert alpha[positions[:, 1] > 0.5 + 0.99 * BORDER_EXTENSION].max() < 0.01  # no straight edge where the mesh ends


def test_shoulders_are_opaque_beyond_the_border() -> None:
    positions = build_mesh(LARGE).positions
    alpha = border_alpha((positions - LARGE.pose.position) / np.exp(LARGE.pose.log_scale), positions, LARGE)
    np.testing.assert_array_equal(alpha[positions[:, 1] < -0.4], 1)
