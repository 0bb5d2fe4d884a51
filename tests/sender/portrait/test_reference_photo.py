import numpy as np

from conf.face.head_pose import HeadPose
from conf.face.portrait.patch_features import FEATURES, MOUTH
from conf.sender.portrait.photo_builder import build_photo
from conf.sender.portrait.reference_photo import ReferencePhoto, patch_residual
from tests.sender.portrait.test_occlusion import shaded
from tests.support.portrait_subjects import canonical, landmarks, motion, shot
from tests.support.synthetic_portrait import POSE


def test_what_looks_like_the_photograph_fits_and_what_is_turned_away_does_not() -> None:
    lit = shot(shaded())
    hanging = ReferencePhoto.create(build_photo(lit, canonical(), 1), lit, 0.0)
    turned = HeadPose(POSE.rotation + np.array((0, 0.6, 0)), POSE.position, POSE.log_scale)
    for region in range(len(FEATURES)):
        assert hanging.can_patch(lit, motion(), region)
        assert not hanging.can_patch(lit, motion(pose=turned), region)


def test_what_is_as_in_the_photograph_does_not_differ_whatever_the_light() -> None:
    lit = shot(shaded())
    hanging = ReferencePhoto.create(build_photo(lit, canonical(), 1), lit, 0.0)
    for light in (1.0, 0.7):
        seen = shot(np.clip(shaded() * light, 0, 255).astype(np.uint8))
        difference, points = patch_residual(hanging, seen, motion(), MOUTH)
        assert np.abs(difference).mean() < 5
        assert points.shape == (len(MOUTH.points), 2)


def test_a_mouth_that_is_painted_over_differs_there_and_nowhere_else() -> None:
    lit = shot(shaded())
    hanging = ReferencePhoto.create(build_photo(lit, canonical(), 1), lit, 0.0)
    painted = shaded()
    x, y = landmarks()[13, :2].astype(int)
    painted[y - 3 : y + 4, x - 6 : x + 7] = (255, 255, 255)
    difference, _ = patch_residual(hanging, shot(painted), motion(), MOUTH)
    height, width = difference.shape[:2]
    middle = difference[height // 3 : 2 * height // 3, width // 3 : 2 * width // 3]
    assert middle.max() > 60 and np.abs(difference[0]).max() == 0
