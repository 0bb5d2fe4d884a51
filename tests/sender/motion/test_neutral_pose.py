import numpy as np
import pytest
from numpy.typing import NDArray

from conf.face.control_points import PUPILS, control_point_indices
from conf.sender.motion.expression_offsets import _load_map, expression_offsets
from conf.sender.motion.eye_openness import lid_gaps
from conf.sender.motion.mean_face import MEAN_FACE
from conf.sender.motion.neutral_pose import (
    ACTIVITY_SCALE,
    LIP_GAP_CM,
    MIN_LID_GAP_CM,
    PRIOR_S,
    REGIONS,
    NeutralPoseEstimator,
    close_mouth_open_eyes,
)
from conf.sender.tracking.blendshape_network import BLENDSHAPE_NAMES
from conf.sender.tracking.blendshape_network import INDEX as SHAPE
from tests.sender.motion.test_mean_face import points_named

FPS = 25
PERSON = MEAN_FACE + np.random.default_rng(3).normal(scale=0.1, size=MEAN_FACE.shape)
PERSON[:, 1] += close_mouth_open_eyes(PERSON)[:, 1] - PERSON[:, 1]
SHIFTED = MEAN_FACE + np.array([0.3, 0.2, 0.1])  # lips and lids keep their gaps
MOUTH, BROWS = control_point_indices("inner_lip", "outer_lip", "chin"), control_point_indices("brow")
LOWER_INNER_LIP = points_named("inner_lip_lower_mid", "inner_lip_lower_l", "inner_lip_lower_r")
ALL_POINTS = list(range(50))
MOUTH_POINT, BROW_POINT, LID_POINT, PUPIL_POINT, CORNER_POINT = points_named(
    "chin_boss", "brow_top_l", "eye_upper_outer_lid_l", "pupil_l", "eye_inner_corner_l"
)


def unexplained() -> NeutralPoseEstimator:
    """Return an estimator for points that no blendshape explains, so that its weights can be measured."""
    return NeutralPoseEstimator(lambda _: np.zeros(MEAN_FACE.shape))


def shapes(**strengths: float) -> NDArray[np.float32]:
    values = np.zeros(52, np.float32)
    for name, strength in strengths.items():
        values[SHAPE[name]] = strength
    return values


def talking(phase: float) -> tuple[NDArray[np.float64], NDArray[np.float32]]:
    """Return a face whose jaw moves up and down four times a second and is never quite shut."""
    opening = 0.6 + 0.4 * np.sin(2 * np.pi * 4 * phase)
    points = PERSON.copy()
    points[control_point_indices("inner_lip_lower", "outer_lip_lower", "chin"), 1] -= 1.5 * opening
    return points, shapes(jawOpen=0.5 * opening)


def observe(
    neutral: NeutralPoseEstimator,
    seconds: float,
    points: NDArray[np.float64],
    blendshapes: NDArray[np.float32],
    *,
    start: float = 0.0,
) -> None:
    for i in range(round(seconds * FPS)):
        now = start + i / FPS
        neutral.update(points, blendshapes, turn=0.0, timestamp=now)
        neutral.blended(now)


def error_mm(neutral: NeutralPoseEstimator, points: list[int]) -> float:
    """Return the mean error of the neutral pose."""
    return float(10 * np.abs(neutral.points - PERSON)[points].mean())


def progress(neutral: NeutralPoseEstimator, point: int) -> float:
    """Return how far the estimate has moved from the mean face, 0, to SHIFTED, 1, at a control point."""
    neutral.reset_clock()
    moved = (neutral.blended(0.0) - MEAN_FACE)[point] / (0.3, 0.2, 0.1)
    assert moved == pytest.approx(moved[0])
    return float(moved[0])


def progress_while_active(shape: str, point: int) -> float:
    """Return the progress of a point that is learned for 2 s, then moves for 1 s while a blendshape is 1.

    Pupils move by themselves, without the corners of their eye.
    """
    neutral, moved = unexplained(), MEAN_FACE.copy()
    others = PUPILS if point in PUPILS else np.setdiff1d(ALL_POINTS, PUPILS)
    moved[others] = SHIFTED[others]
    for i in range(15):
        points, weights = (MEAN_FACE, shapes()) if i < 10 else (moved, shapes(**{shape: 1.0}))
        neutral.update(points, weights, turn=0.0, timestamp=i * 0.2)
    return progress(neutral, point)


def test_every_control_point_belongs_to_one_region() -> None:
    assert sorted(i for region in REGIONS for i in region) == ALL_POINTS


@pytest.mark.parametrize(
    ("elapsed", "weight"), [(0.0, 0.2), (0.1, 0.3), (0.2, 0.4), (0.3, 0.4), (3600.0, 0.4), (-1.0, 0.2)]
)
def test_a_frame_counts_for_the_time_since_the_last_at_most_0_2_s(elapsed: float, weight: float) -> None:
    neutral = unexplained()
    for timestamp in (5.0, 5.0 + elapsed):
        neutral.update(SHIFTED, shapes(), turn=0.0, timestamp=timestamp)
    assert progress(neutral, MOUTH_POINT) == pytest.approx(weight / (PRIOR_S + weight))


@pytest.mark.parametrize(
    ("seconds", "strength", "floor"), [(1.0, 0.12, 0.12), (3.0, 0.24, 0.24), (2.0, 0.36, 0.3), (4.0, 0.6, 0.3)]
)
def test_a_constant_activity_weighs_less_and_is_accepted_with_time(
    seconds: float, strength: float, floor: float
) -> None:
    neutral = unexplained()
    for i in range(round(seconds / 0.2)):
        neutral.update(SHIFTED, shapes(browInnerUp=strength), turn=0.0, timestamp=i * 0.2)
    weight = seconds * np.exp(-strength / ACTIVITY_SCALE)
    prior = PRIOR_S * np.exp(-floor * (1 - np.exp(-seconds / 2.0)) / ACTIVITY_SCALE)
    assert progress(neutral, BROW_POINT) == pytest.approx(weight / (weight + prior), rel=1e-5)
    assert progress(neutral, MOUTH_POINT) == pytest.approx(seconds / (seconds + PRIOR_S))


def test_the_lowest_activity_counts_as_the_floor() -> None:
    neutral = unexplained()
    for i, strength in enumerate((0.5, 0.24, 0.36)):
        neutral.update(SHIFTED, shapes(browInnerUp=strength), turn=0.0, timestamp=i * 0.2)
    weight = 0.2 * sum(np.exp(-np.array([0.5, 0.24, 0.36]) / ACTIVITY_SCALE))
    prior = PRIOR_S * np.exp(-0.24 * (1 - np.exp(-0.6 / 2.0)) / ACTIVITY_SCALE)
    assert progress(neutral, BROW_POINT) == pytest.approx(weight / (weight + prior), rel=1e-5)


@pytest.mark.parametrize(
    ("shape", "points"),
    [
        ("jawOpen", {MOUTH_POINT}),
        ("mouthSmileLeft", {MOUTH_POINT, BROW_POINT, LID_POINT}),
        ("mouthLowerDownRight", {MOUTH_POINT}),
        ("browDownLeft", {BROW_POINT}),
        ("browOuterUpRight", {BROW_POINT}),
        ("eyeBlinkLeft", {BROW_POINT, LID_POINT, PUPIL_POINT, CORNER_POINT}),
        ("eyeBlinkRight", {BROW_POINT, LID_POINT, PUPIL_POINT, CORNER_POINT}),
        ("eyeWideLeft", {LID_POINT}),
        ("eyeLookUpLeft", {LID_POINT, PUPIL_POINT}),
        ("eyeLookInLeft", {PUPIL_POINT}),
        ("cheekPuff", set()),
    ],
)
def test_which_points_a_blendshape_affects(shape: str, points: set[int]) -> None:
    every = (MOUTH_POINT, BROW_POINT, LID_POINT, PUPIL_POINT, CORNER_POINT)
    found = {point for point in every if progress_while_active(shape, point) < 0.1}
    assert found == points


def test_only_blendshapes_of_expressions_are_used() -> None:
    unused = {
        *("neutral", "cheekPuff", "cheekSquintLeft", "cheekSquintRight", "eyeLookDownRight", "eyeLookInRight"),
        *("eyeLookOutRight", "eyeLookUpRight", "jawForward", "mouthClose"),
        *("mouthDimpleLeft", "mouthDimpleRight", "mouthPressLeft", "mouthPressRight", "mouthRollLower"),
        *("mouthRollUpper", "mouthShrugLower", "mouthShrugUpper", "noseSneerLeft", "noseSneerRight"),
    }
    for name in BLENDSHAPE_NAMES:
        lowest = min(progress_while_active(name, region[0]) for region in REGIONS)
        assert (lowest > 0.3) == (name in unused), name


@pytest.mark.parametrize(("turn_degrees", "exponent"), [(0.0, 0.0), (36.0, 1.0), (-36.0, 1.0), (72.0, 4.0)])
def test_a_turned_head_weighs_less(turn_degrees: float, exponent: float) -> None:
    neutral = unexplained()
    neutral.update(SHIFTED, shapes(), turn=np.radians(turn_degrees), timestamp=0.0)
    weight = 0.2 * np.exp(-exponent)
    prior = PRIOR_S * np.exp(-min(exponent * ACTIVITY_SCALE, 0.3) * (1 - np.exp(-0.2 / 2.0)) / ACTIVITY_SCALE)
    assert progress(neutral, MOUTH_POINT) == pytest.approx(weight / (weight + prior))


def test_thirty_seconds_without_activity_are_remembered() -> None:
    neutral = unexplained()
    for i in range(200):
        neutral.update(MEAN_FACE, shapes(), turn=0.0, timestamp=i * 0.2)
    for i in range(5):
        neutral.update(SHIFTED, shapes(), turn=0.0, timestamp=40 + i * 0.2)
    new = sum(0.2 * (30 / 30.2) ** k for k in range(1, 6))
    assert progress(neutral, MOUTH_POINT) == pytest.approx(new / (30 + PRIOR_S))


@pytest.mark.slow
def test_an_active_face_has_a_smaller_memory() -> None:
    neutral = unexplained()
    for i in range(2000):
        neutral.update(MEAN_FACE, shapes(browInnerUp=0.6), turn=0.0, timestamp=i * 0.2)
    neutral.update(SHIFTED, shapes(), turn=0.0, timestamp=400.0)
    remembered = 30 * np.exp(-0.3 / ACTIVITY_SCALE)
    assert progress(neutral, BROW_POINT) == pytest.approx(0.2 / (remembered + 0.2 + PRIOR_S), rel=1e-4)


@pytest.mark.parametrize(("times", "known"), [((0.0,), False), ((0.0, 0.099), False), ((0.0, 0.101), True)])
def test_a_face_is_known_after_0_3_s_without_activity(times: tuple[float, ...], known: bool) -> None:
    neutral = unexplained()
    for timestamp in times:
        neutral.update(MEAN_FACE, shapes(), turn=0.0, timestamp=timestamp)
    assert neutral.known == known


def test_a_face_is_not_known_while_a_region_is_active() -> None:
    neutral = unexplained()
    for i in range(4):
        neutral.update(MEAN_FACE, shapes(jawOpen=0.5), turn=0.0, timestamp=i * 0.2)
    assert not neutral.known
    for i in range(4, 6):
        neutral.update(MEAN_FACE, shapes(), turn=0.0, timestamp=i * 0.2)
    assert neutral.known


def test_a_permanently_active_region_becomes_known() -> None:
    def is_known(seconds: float) -> bool:
        neutral = unexplained()
        for i in range(round(seconds / 0.2)):
            neutral.update(MEAN_FACE, shapes(browInnerUp=0.24), turn=0.0, timestamp=i * 0.2)
        return neutral.known

    # t exp(-0.6) against 0.3 exp(-0.6 (1 - exp(-t / 2))): they meet at 0.48 s
    assert [is_known(seconds) for seconds in (0.4, 0.6)] == [False, True]


@pytest.mark.parametrize(
    ("elapsed", "alpha"), [(0.0, 0.0), (0.1, 1 - np.exp(-0.4)), (0.25, 1 - np.exp(-1)), (-1.0, 0.0)]
)
def test_the_pose_in_use_follows_the_estimate_with_0_25_s(elapsed: float, alpha: float) -> None:
    neutral = unexplained()
    assert np.allclose(neutral.blended(7.0), MEAN_FACE)
    neutral.update(SHIFTED, shapes(), turn=0.0, timestamp=7.0)
    assert neutral.blended(7.0 + elapsed) == pytest.approx(
        MEAN_FACE + alpha * 0.2 / (0.2 + PRIOR_S) * (SHIFTED - MEAN_FACE)
    )
    assert np.array_equal(neutral.points, neutral.blended(7.0 + elapsed))


def test_at_the_start_the_mean_face_is_used() -> None:
    neutral = unexplained()
    assert np.array_equal(neutral.points, MEAN_FACE)
    assert np.allclose(neutral.blended(0.0), MEAN_FACE)
    assert not neutral.known


def test_a_face_without_activity_is_known_within_a_second() -> None:
    neutral = unexplained()
    observe(neutral, 1.0, PERSON, shapes())
    assert neutral.known
    assert error_mm(neutral, ALL_POINTS) < 0.25
    observe(neutral, 4.0, PERSON, shapes(), start=1.0)
    assert error_mm(neutral, ALL_POINTS) < 0.06


def test_the_neutral_mouth_of_a_talker_is_shut() -> None:
    neutral = unexplained()
    for i in range(5 * FPS):
        neutral.update(*talking(i / FPS), turn=0.0, timestamp=i / FPS)
        neutral.blended(i / FPS)
    upper, lower = points_named("inner_lip_upper_mid", "inner_lip_lower_mid")
    assert neutral.points[upper, 1] - neutral.points[lower, 1] < LIP_GAP_CM + 0.02
    assert error_mm(neutral, BROWS) < 0.2
    assert error_mm(neutral, MOUTH) < 1.5


def test_a_blink_or_a_smile_changes_a_known_pose_little() -> None:
    neutral = unexplained()
    observe(neutral, 2.0, PERSON, shapes())
    smile = PERSON.copy()
    smile[control_point_indices("outer_lip_corner_l"), 0] += 0.8
    smile[control_point_indices("eyelid_upper"), 1] -= 0.8
    observe(neutral, 10.0, smile, shapes(mouthSmileLeft=0.7, eyeBlinkLeft=0.8, eyeBlinkRight=0.8), start=2.0)
    assert error_mm(neutral, ALL_POINTS) < 0.12


@pytest.mark.parametrize(
    "expression",
    [
        {"eyeBlinkLeft": 0.85, "eyeBlinkRight": 0.85, "eyeLookDownLeft": 0.8, "browDownLeft": 0.06},
        {"mouthSmileLeft": 0.9, "mouthSmileRight": 0.9, "browDownLeft": 0.02},
        {"eyeSquintLeft": 0.65, "eyeSquintRight": 0.6, "browDownLeft": 0.05},
    ],
    ids=["cry", "laugh", "squint"],
)
def test_brows_of_an_emotion_do_not_become_neutral(expression: dict[str, float]) -> None:
    knit = PERSON.copy()
    knit[BROWS] += (0.0, -0.5, 0.1)
    neutral = unexplained()
    observe(neutral, 0.5, PERSON, shapes(eyeSquintLeft=0.1))
    observe(neutral, 5.0, knit, shapes(**expression), start=0.5)
    assert error_mm(neutral, BROWS) < 1.3  # 2 are learned where an expression goes unseen
    observe(neutral, 5.0, PERSON, shapes(eyeSquintLeft=0.1), start=5.5)
    assert error_mm(neutral, BROWS) < 0.4


def test_a_constant_squint_is_neutral() -> None:
    neutral = unexplained()
    observe(neutral, 3.0, PERSON, shapes(eyeSquintLeft=0.5, eyeSquintRight=0.5))
    assert neutral.known
    assert error_mm(neutral, ALL_POINTS) < 0.1


def test_permanently_high_brows_become_neutral() -> None:
    neutral = unexplained()
    observe(neutral, 8.0, PERSON, shapes(browInnerUp=0.35))
    assert error_mm(neutral, BROWS) < 0.3


@pytest.mark.parametrize(
    "expression",
    [
        {"mouthSmileLeft": 0.9, "mouthSmileRight": 0.9},
        {"browInnerUp": 0.6, "browOuterUpLeft": 0.5, "browOuterUpRight": 0.5},
        {"jawOpen": 0.4},
    ],
    ids=["smile", "raised brows", "open mouth"],
)
def test_an_expression_from_the_first_frame_on_does_not_become_neutral(expression: dict[str, float]) -> None:
    quiet = _load_map()[1]
    weights = np.maximum(quiet, shapes(**expression))
    moved = expression_offsets(weights)
    active = PERSON + moved
    active[PUPILS] = PERSON[PUPILS]
    explained, unaided = NeutralPoseEstimator(), unexplained()
    for neutral in (explained, unaided):
        observe(neutral, 10.0, active, weights.astype(np.float32))
    [largest] = np.argsort(-np.abs(moved).max(axis=1))[:1].tolist()
    assert error_mm(explained, [largest]) < 0.3 * error_mm(unaided, [largest])
    assert error_mm(explained, ALL_POINTS) < 0.25


def test_the_pose_in_use_never_jumps() -> None:
    neutral = unexplained()
    used = []
    far = PERSON + np.array([0.5, 0.5, 0.0])
    for i in range(3 * FPS):
        neutral.update(PERSON if i < FPS else far, shapes(), turn=0.0, timestamp=i / FPS)
        used.append(neutral.blended(i / FPS))
    assert np.abs(np.diff(used, axis=0)).max() < 0.08


def test_a_pose_that_was_set_is_used_at_once_and_stays() -> None:
    neutral = unexplained()
    neutral.set(PERSON)
    assert neutral.known
    observe(neutral, 5.0, MEAN_FACE, shapes())
    assert np.allclose(neutral.points, PERSON)


def test_a_pose_is_set_with_shut_mouth_and_open_eyes() -> None:
    neutral = unexplained()
    points, _ = talking(0.125)
    neutral.set(points)
    np.testing.assert_array_equal(neutral.points, close_mouth_open_eyes(points))


def test_after_a_reset_the_clock_starts_again() -> None:
    neutral, fresh = unexplained(), unexplained()
    for estimator in (neutral, fresh):
        for i in range(FPS):
            estimator.update(PERSON, shapes(), turn=0.0, timestamp=i / FPS)
    neutral.blended(1.0)
    neutral.reset_clock()
    assert np.abs(neutral.blended(0.0) - PERSON).mean() < 0.02
    neutral.update(SHIFTED, shapes(), turn=0.0, timestamp=1000.0)  # counts for 0.2 s, as a first frame does
    fresh.update(SHIFTED, shapes(), turn=0.0, timestamp=1000.0)
    neutral.reset_clock()
    assert np.allclose(neutral.blended(0.0), fresh.blended(0.0))


def parted(mid: float, left: float, right: float) -> NDArray[np.float64]:
    """Return the mean face with the inner lips apart by these gaps, cm."""
    points = MEAN_FACE.copy()
    upper = points_named("inner_lip_upper_mid", "inner_lip_upper_l", "inner_lip_upper_r")
    points[LOWER_INNER_LIP, 1] = points[upper, 1] - (mid, left, right)
    return points


def test_a_parted_mouth_is_shut() -> None:
    points = parted(0.45, 0.25, 0.05)
    raised = close_mouth_open_eyes(points) - points
    expected = np.zeros((50, 3))
    expected[LOWER_INNER_LIP, 1] = (0.4, 0.2, 0.0)
    expected[points_named("outer_lip_lower_mid", "outer_lip_lower_l", "outer_lip_lower_r"), 1] = 0.4
    expected[points_named("chin_bottom", "chin_boss", "chin_corner_l", "chin_corner_r"), 1] = 0.28
    assert raised == pytest.approx(expected)


def test_a_shut_mouth_is_unchanged() -> None:
    points = parted(0.05, 0.02, -0.3)
    assert np.array_equal(close_mouth_open_eyes(points), points)


def test_nearly_shut_lids_are_opened() -> None:
    points = parted(0.0, 0.0, 0.0)
    upper, lower = points_named("eyelid_upper_l", "eyelid_upper_r"), points_named("eyelid_lower_l", "eyelid_lower_r")
    points[upper, 1] = points[lower, 1] + (0.1, 0.5)
    opened = close_mouth_open_eyes(points)
    assert lid_gaps(opened) == pytest.approx([0.4, 0.5])
    points[upper[0], 1] += MIN_LID_GAP_CM - 0.1
    assert opened == pytest.approx(points)
