import numpy as np

from conf.face.control_points import CONTROL_POINT_INDEX
from conf.face.head_pose import HeadPose
from conf.face.portrait.head_weights import SHOULDER_WEIGHT, head_weights
from conf.face.portrait.photo_mesh import build_mesh
from tests.support.synthetic_portrait import POSE, face_shape


def test_head_follows_wholly_shoulders_in_part_and_the_bottom_not_at_all() -> None:
    shape = face_shape()
    places = build_mesh(shape).positions
    share = head_weights((places - POSE.position) / np.exp(POSE.log_scale), places, shape)
    assert (share >= 0).all() and (share <= 1).all()
    above = (places[:, 1] > 0.2) & (np.abs(places[:, 0] - 0.03) < 0.2)
    np.testing.assert_allclose(share[above], 1)
    assert share[places[:, 1] <= -0.5].max() == 0
    assert share[np.abs(places[:, 0]) > 0.72].max() <= SHOULDER_WEIGHT + 1e-9


def test_with_the_chin_at_the_border_the_neck_still_follows() -> None:
    shape = face_shape(HeadPose(POSE.rotation, np.array([0.03, -0.18]), POSE.log_scale))
    places = build_mesh(shape).positions
    share = head_weights((places - shape.pose.position) / np.exp(POSE.log_scale), places, shape)
    chin = places[CONTROL_POINT_INDEX["chin_bottom"]]
    below = np.linalg.norm(places - (chin[0], -0.5), axis=1) < 0.1
    assert chin[1] < -0.4 and share[below & (places[:, 1] > -0.51)].min() > 0.3
