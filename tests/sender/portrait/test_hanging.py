import numpy as np

from conf.face.head_pose import HeadPose
from conf.face.portrait.features import FEATURES, MOUTH
from conf.sender.portrait.hanging import Hanging, cut_for
from conf.sender.portrait.photographer import take_photograph
from tests.face.portrait.synthetic import POSE
from tests.sender.portrait.subjects import canonical, motion, shot
from tests.sender.portrait.test_agreement import shaded


def test_what_looks_like_the_photograph_fits_and_what_is_turned_away_does_not() -> None:
    lit = shot(shaded())
    hanging = Hanging.of(take_photograph(lit, canonical(), 1), lit, 0.0)
    turned = HeadPose(POSE.rotation + np.array((0, 0.6, 0)), POSE.position, POSE.log_scale)
    for region in range(len(FEATURES)):
        assert hanging.fits(lit, motion(), region)
        assert not hanging.fits(lit, motion(pose=turned), region)


def test_a_cut_out_keeps_the_photograph_s_light() -> None:
    lit = shot(shaded())
    hanging = Hanging.of(take_photograph(lit, canonical(), 1), lit, 0.0)
    dark = shot(np.clip(shaded() * 0.7, 0, 255).astype(np.uint8))
    plain, points = cut_for(hanging, lit, motion(), MOUTH)
    matched, _ = cut_for(hanging, dark, motion(), MOUTH)
    assert np.abs(plain.astype(float) - matched).mean() < 5
    assert points.shape == (len(MOUTH.points), 2)
