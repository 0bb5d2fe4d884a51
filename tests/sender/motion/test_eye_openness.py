import numpy as np
import pytest
from numpy.typing import NDArray

from conf.sender.motion.eye_openness import EyeOpennessEstimator, lid_gaps
from conf.sender.motion.mean_face import MEAN_FACE
from conf.sender.tracking.blendshape_network import INDEX as SHAPE
from tests.sender.motion.test_mean_face import points_named

UPPER, LOWER = points_named("eyelid_upper_l", "eyelid_upper_r"), points_named("eyelid_lower_l", "eyelid_lower_r")
NEUTRAL_GAPS = MEAN_FACE[UPPER, 1] - MEAN_FACE[LOWER, 1]


def with_gaps(left: float, right: float) -> NDArray[np.float64]:
    """Return the mean face with lid gaps of these ratios of the neutral gap."""
    points = MEAN_FACE.copy()
    points[UPPER, 1] = points[LOWER, 1] + NEUTRAL_GAPS * (left, right)
    return points


def blink(left: float, right: float) -> NDArray[np.float64]:
    shapes = np.zeros(52)
    shapes[[SHAPE["eyeBlinkLeft"], SHAPE["eyeBlinkRight"]]] = left, right
    return shapes


def test_lid_gaps_are_measured_from_the_lower_to_the_upper_lid() -> None:
    points = np.zeros((50, 3))
    points[UPPER, 1], points[LOWER, 1] = (3.0, 4.0), (1.0, -1.0)
    assert lid_gaps(points) == pytest.approx([2.0, 5.0])


@pytest.mark.parametrize(
    ("gap", "openness"),
    [(-0.3, 0.0), (0.0, 0.0), (0.16, 0.0), (0.58, 0.5), (1.0, 1.0), (1.42, 1.5), (1.84, 2.0), (9.0, 2.0)],
)
def test_openness_of_a_gap_before_any_blink(gap: float, openness: float) -> None:
    assert EyeOpennessEstimator().openness(with_gaps(gap, 1.0), MEAN_FACE) == pytest.approx([openness, 1.0])
    assert EyeOpennessEstimator().openness(with_gaps(1.0, gap), MEAN_FACE) == pytest.approx([1.0, openness])


@pytest.mark.parametrize(
    ("gap", "shape", "learned"),
    [
        (0.26, 0.65, 0.17),  # a tenth of the way from 0.16
        (0.26, 0.64, 0.16),
        (0.06, 1.0, 0.15),
        (-0.5, 1.0, 0.144),  # as a gap of 0
        (1.0, 1.0, 0.174),  # as a gap of 0.3
    ],
)
def test_one_frame_of_a_blink_teaches_the_gap_of_the_shut_eye(gap: float, shape: float, learned: float) -> None:
    for eye in (0, 1):
        estimator = EyeOpennessEstimator()
        gaps, shapes, expected = [1.0, 1.0], [0.0, 0.0], [0.16, 0.16]
        gaps[eye], shapes[eye], expected[eye] = gap, shape, learned
        estimator.update(with_gaps(*gaps), MEAN_FACE, blink(*shapes))
        assert estimator.closed_gap_ratio == pytest.approx(expected)


@pytest.mark.parametrize(("shape", "openness"), [(0.79, 0.19), (0.8, 0.0)])
def test_an_eye_that_looks_down_stays_half_shut(shape: float, openness: float) -> None:
    """Its blink shape has up to 0.77; a shut eye's gap is at most 0.3 of the neutral one."""
    estimator = EyeOpennessEstimator()
    for _ in range(200):
        estimator.update(with_gaps(0.31, 0.32), MEAN_FACE, blink(shape, shape))
    assert estimator.openness(with_gaps(0.32, 0.32), MEAN_FACE) == pytest.approx([openness] * 2, abs=0.03)


def test_each_eye_learns_its_own_gap_from_blinks_alone() -> None:
    estimator = EyeOpennessEstimator()
    for _ in range(60):
        estimator.update(with_gaps(0.25, 0.5), MEAN_FACE, blink(0.8, 0.3))
    assert estimator.closed_gap_ratio == pytest.approx([0.25, 0.16], abs=0.001)
    assert estimator.openness(with_gaps(0.25, 1), MEAN_FACE)[0] == pytest.approx(0, abs=0.002)


def test_wrong_blendshapes_cannot_shut_open_eyes() -> None:
    estimator = EyeOpennessEstimator()
    for _ in range(200):
        estimator.update(MEAN_FACE, MEAN_FACE, blink(1, 1))
    assert estimator.closed_gap_ratio == pytest.approx([0.3] * 2)
    assert estimator.openness(MEAN_FACE, MEAN_FACE) == pytest.approx([1, 1])
