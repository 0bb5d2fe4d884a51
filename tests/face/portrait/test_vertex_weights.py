import numpy as np

from conf.face.control_points import CONTROL_POINT_INDEX
from conf.face.head_pose import HeadPose
from conf.face.portrait.photo_mesh import build_mesh
from conf.face.portrait.vertex_weights import SHOULDER_WEIGHTS, head_weights
from tests.support.synthetic_portrait import POSE, face_shape


def test_weights_of_head_shoulders_and_lower_border() -> None:
    face = face_shape()
    positions = build_mesh(face).positions
    weights = head_weights((positions - POSE.position) / np.exp(POSE.log_scale), positions, face)
    assert (weights >= 0).all() and (weights <= 1).all()
    above = (positions[:, 1] > 0.2) & (np.abs(positions[:, 0] - 0.03) < 0.2)
    np.testing.assert_allclose(weights[above], 1)
    assert weights[positions[:, 1] <= -0.5].max() == 0
    assert (weights[np.abs(positions[:, 0]) > 0.72].max(axis=0) <= np.array(SHOULDER_WEIGHTS) + 1e-9).all()


def test_with_the_chin_at_the_border_the_neck_still_follows_the_head() -> None:
    face = face_shape(HeadPose(POSE.rotation, np.array([0.03, -0.18]), POSE.log_scale))
    positions = build_mesh(face).positions
    weights = head_weights((positions - face.pose.position) / np.exp(POSE.log_scale), positions, face)
    chin = positions[CONTROL_POINT_INDEX["chin_bottom"]]
    below = np.linalg.norm(positions - (chin[0], -0.5), axis=1) < 0.1
    assert chin[1] < -0.4 and weights[below & (positions[:, 1] > -0.51)].min() > 0.3
