import numpy as np
import pytest

from conf.sender.motion.eye_openness import MAX_SHUT_SHARE, SHUT_SHARE, UPPER, EyeOpennessEstimator, lid_gaps
from conf.sender.motion.mean_face import MEAN_FACE
from conf.sender.tracking.blendshape_network import INDEX as SHAPE

OPEN = lid_gaps(MEAN_FACE)


def with_gaps(left: float, right: float) -> np.ndarray:
    """The mean face with its lids apart by these shares of their neutral gap."""
    points = MEAN_FACE.copy()
    points[UPPER, 1] += OPEN * (np.array([left, right]) - 1)
    return points


def blink(left: float, right: float) -> np.ndarray:
    shapes = np.zeros(52)
    shapes[[SHAPE["eyeBlinkLeft"], SHAPE["eyeBlinkRight"]]] = left, right
    return shapes


def test_neutral_is_one_and_what_a_shut_eye_leaves_is_nought() -> None:
    gauge = EyeOpennessEstimator()
    assert gauge.openness(MEAN_FACE, MEAN_FACE) == pytest.approx([1, 1])
    assert gauge.openness(with_gaps(SHUT_SHARE, 0.5), MEAN_FACE) == pytest.approx(
        [0, (0.5 - SHUT_SHARE) / (1 - SHUT_SHARE)]
    )


def test_lids_never_cross_and_eyes_never_pop() -> None:
    assert np.array_equal(EyeOpennessEstimator().openness(with_gaps(-0.3, 9.0), MEAN_FACE), [0, 2])


def test_each_eye_learns_its_own_shut_gap_from_blinks_alone() -> None:
    gauge = EyeOpennessEstimator()
    for _ in range(60):
        gauge.update(with_gaps(0.25, 0.5), MEAN_FACE, blink(0.8, 0.3))
    assert gauge.closed_gap_ratio == pytest.approx([0.25, SHUT_SHARE], abs=0.001)
    assert gauge.openness(with_gaps(0.25, 1), MEAN_FACE)[0] == pytest.approx(0, abs=0.002)


def test_a_lying_blendshape_cannot_shut_open_eyes() -> None:
    gauge = EyeOpennessEstimator()
    for _ in range(200):
        gauge.update(MEAN_FACE, MEAN_FACE, blink(1, 1))
    assert gauge.closed_gap_ratio == pytest.approx([MAX_SHUT_SHARE] * 2)
    assert gauge.openness(MEAN_FACE, MEAN_FACE) == pytest.approx([1, 1])
