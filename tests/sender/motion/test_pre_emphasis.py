import numpy as np
import pytest

from conf.face.control_points import CONTROL_POINT_COUNT, control_point_indices
from conf.sender.motion.pre_emphasis import (
    BROW_GAIN_X,
    BROW_GAIN_Y,
    LID_GAIN,
    LIP_GAIN,
    PUPIL_GAIN_X,
    emphasise,
    emphasise_openness,
)
from tools.bench.expression_curves import GRADIENTS, NAMES

GAINS = {
    "brow_knit": BROW_GAIN_X,
    "brow_inner_l": BROW_GAIN_Y,
    "brow_outer_r": BROW_GAIN_Y,
    "brow_slant_l": BROW_GAIN_Y,
    "upper_lip_thickness": LIP_GAIN,
    "lower_lip_thickness": LIP_GAIN,
    "gaze_x": PUPIL_GAIN_X,
    "gaze_y": 1.0,
    "mouth_opening": 1.0,
    "mouth_width": 1.0,
}


def moved(seed: int) -> np.ndarray:
    return np.random.default_rng(seed).normal(0, 20, (CONTROL_POINT_COUNT, 3))


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize(("curve", "gain"), GAINS.items())
def test_each_curve_of_an_expression_grows_by_its_gain(curve: str, gain: float, seed: int) -> None:
    gradient, displacements = GRADIENTS[NAMES.index(curve)], moved(seed)
    before, after = (float((gradient * motion).sum()) for motion in (displacements, emphasise(displacements)))
    assert after == pytest.approx(gain * before)


def test_the_neutral_pose_stays() -> None:
    assert not emphasise(np.zeros((CONTROL_POINT_COUNT, 3))).any()


def test_a_lip_that_keeps_its_thickness_is_not_changed() -> None:
    displacements = np.zeros((CONTROL_POINT_COUNT, 3))
    displacements[control_point_indices("inner_lip_lower", "outer_lip_lower", "chin"), 1] = -300.0
    assert np.array_equal(emphasise(displacements), displacements)


def test_the_argument_is_not_changed() -> None:
    displacements = moved(0)
    before = displacements.copy()
    emphasise(displacements)
    assert np.array_equal(displacements, before)


def test_shut_eyes_stay_shut_and_resting_eyes_at_rest() -> None:
    assert emphasise_openness(np.array([0.0, 1.0])) == pytest.approx([0.0, 1.0])
    assert emphasise_openness(np.array([0.5, 1.5])) == pytest.approx([1 - 0.5 * LID_GAIN, 1 + 0.5 * LID_GAIN])
