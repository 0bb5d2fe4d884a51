import numpy as np

from conf.face.head_pose import HeadPose
from conf.face.portrait.photographed_face import project
from tests.support.synthetic_portrait import face_shape

QUARTER_TURN = HeadPose(np.array([0.0, 0.0, np.pi / 2]), np.array([0.1, -0.2]), float(np.log(0.05)))


def test_points_are_projected_with_the_head_pose() -> None:
    np.testing.assert_allclose(project(np.array([[2.0, 0.0, 9.0]]), QUARTER_TURN), [[0.1, -0.1]], atol=1e-12)


def test_upright_positions_have_the_crown_at_the_top() -> None:
    np.testing.assert_allclose(face_shape(QUARTER_TURN).upright(np.array([[-3.0, 0.0]])), [[0.0, 3.0]], atol=1e-12)
