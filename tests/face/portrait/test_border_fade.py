import numpy as np

from conf.face.head_pose import HeadPose
from conf.face.portrait.border_fade import border_alpha
from conf.face.portrait.person_outline import BORDER_EXTENSION
from conf.face.portrait.photo_mesh import build_mesh
from tests.support.synthetic_portrait import POSE, face_shape

# A head so large and high that the picture's upper border cuts its crown off.
LARGE = face_shape(HeadPose(POSE.rotation, np.array([0.1, 0.15]), float(np.log(0.04))))


def test_a_crown_goes_on_beyond_the_border_and_streaks_do_not() -> None:
    pose = LARGE.pose
    places = build_mesh(LARGE).positions
    shown = border_alpha((places - pose.position) / np.exp(pose.log_scale), places, LARGE)
    assert (shown >= 0).all() and (shown <= 1).all()
    inside = (np.abs(places) <= (LARGE.aspect / 2 + 1e-9, 0.5 + 1e-9)).all(axis=1)
    np.testing.assert_array_equal(shown[inside], 1)
    above = ~inside & (places[:, 1] > 0.5)
    over_the_face = np.abs(places[:, 0] - pose.position[0]) < 0.1
    assert shown[above & over_the_face].max() > 0.9
    assert shown[above & (np.abs(places[:, 0]) > 0.6)].max() == 0
    assert shown[places[:, 1] > 0.5 + 0.99 * BORDER_EXTENSION].max() < 0.01  # no straight edge where the mesh ends


def test_shoulders_go_on_below_and_beside() -> None:
    places = build_mesh(LARGE).positions
    shown = border_alpha((places - LARGE.pose.position) / np.exp(LARGE.pose.log_scale), places, LARGE)
    np.testing.assert_array_equal(shown[places[:, 1] < -0.4], 1)
