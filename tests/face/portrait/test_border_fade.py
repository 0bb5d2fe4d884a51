import numpy as np

from conf.face.head_pose import HeadPose
from conf.face.portrait.border_fade import border_alpha
from conf.face.portrait.person_outline import BORDER_EXTENSION
from conf.face.portrait.photo_mesh import build_mesh
from tests.support.synthetic_portrait import POSE, face_shape

# A head so large and high that the upper border cuts off its crown.
LARGE = face_shape(HeadPose(POSE.rotation, np.array([0.1, 0.15]), float(np.log(0.04))))


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
