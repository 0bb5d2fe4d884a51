import numpy as np

from conf.face.head_pose import HeadPose
from conf.face.portrait.photographed_face import project


def test_projects_as_the_pose_says() -> None:
    pose = HeadPose(np.array([0.0, 0.0, np.pi / 2]), np.array([0.1, -0.2]), float(np.log(0.05)))
    np.testing.assert_allclose(project(np.array([[2.0, 0.0, 9.0]]), pose), [[0.1, -0.1]], atol=1e-12)
