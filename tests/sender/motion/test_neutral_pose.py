import numpy as np
import pytest
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_INDEX, control_point_indices
from conf.sender.motion.eye_openness import lid_gaps
from conf.sender.motion.mean_face import MEAN_FACE
from conf.sender.motion.neutral_pose import (
    LIP_GAP_CM,
    MAX_STEP_S,
    MIN_LID_GAP_CM,
    REGIONS,
    NeutralPoseEstimator,
    close_mouth_open_eyes,
)
from conf.sender.tracking.blendshape_network import INDEX as SHAPE

FPS = 25
MINE = MEAN_FACE + np.random.default_rng(3).normal(scale=0.1, size=MEAN_FACE.shape)  # somebody else's neutral face
MINE[:, 1] += close_mouth_open_eyes(MINE)[:, 1] - MINE[:, 1]
MOUTH, BROWS = control_point_indices("inner_lip", "outer_lip", "chin"), control_point_indices("brow")


def shapes(**strengths: float) -> NDArray[np.float32]:
    values = np.zeros(52, np.float32)
    for name, strength in strengths.items():
        values[SHAPE[name]] = strength
    return values


def talking(phase: float) -> tuple[NDArray[np.float64], NDArray[np.float32]]:
    """A face whose jaw goes up and down all the time, four times a second, and never quite shuts."""
    opening = 0.6 + 0.4 * np.sin(2 * np.pi * 4 * phase)
    points = MINE.copy()
    points[control_point_indices("inner_lip_lower", "outer_lip_lower", "chin"), 1] -= 1.5 * opening
    return points, shapes(jawOpen=0.5 * opening)


def watch(
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


def off(neutral: NeutralPoseEstimator, rows: list[int]) -> float:
    """How far, in mm, the neutral pose is from the true one."""
    return float(10 * np.abs(neutral.points - MINE)[rows].mean())


def test_every_control_point_belongs_to_one_region() -> None:
    assert sorted(i for region in REGIONS for i in region.points) == list(range(50))


def test_before_anything_is_seen_the_mean_face_stands_in() -> None:
    neutral = NeutralPoseEstimator()
    assert np.array_equal(neutral.points, MEAN_FACE)
    assert np.allclose(neutral.blended(0.0), MEAN_FACE)
    assert not neutral.known


def test_a_quiet_face_is_known_within_a_second() -> None:
    neutral = NeutralPoseEstimator()
    watch(neutral, 1.0, MINE, shapes())
    assert neutral.known
    assert off(neutral, list(range(50))) < 0.15
    watch(neutral, 4.0, MINE, shapes(), start=1.0)
    assert off(neutral, list(range(50))) < 0.05


def test_a_talker_is_not_taken_for_one_whose_mouth_hangs_open() -> None:
    neutral = NeutralPoseEstimator()
    for i in range(5 * FPS):
        neutral.update(*talking(i / FPS), turn=0.0, timestamp=i / FPS)
        neutral.blended(i / FPS)
    gap = (
        neutral.points[CONTROL_POINT_INDEX["inner_lip_upper_mid"], 1]
        - neutral.points[CONTROL_POINT_INDEX["inner_lip_lower_mid"], 1]
    )
    assert gap == pytest.approx(LIP_GAP_CM, abs=0.1)
    assert off(neutral, MOUTH) < 1.5  # of up to 15 mm that the mouth moves
    assert off(neutral, BROWS) < 0.1  # which did nothing, and are known for it


def test_a_blink_or_a_smile_changes_little_of_what_is_known() -> None:
    neutral = NeutralPoseEstimator()
    watch(neutral, 2.0, MINE, shapes())
    smile = MINE.copy()
    smile[control_point_indices("outer_lip_corner_l"), 0] += 0.8
    smile[control_point_indices("eyelid_upper"), 1] -= 0.8
    watch(neutral, 10.0, smile, shapes(mouthSmileLeft=0.7, eyeBlinkLeft=0.8, eyeBlinkRight=0.8), start=2.0)
    assert off(neutral, list(range(50))) < 0.1


def test_brows_that_lie_high_for_good_become_the_neutral_ones() -> None:
    neutral = NeutralPoseEstimator()
    watch(neutral, 8.0, MINE, shapes(browInnerUp=0.35))
    assert off(neutral, BROWS) < 0.3


def test_a_lasting_smile_does_not_soon_become_the_neutral_pose() -> None:
    neutral = NeutralPoseEstimator()
    smile = MEAN_FACE.copy()
    smile[control_point_indices("outer_lip_corner_l"), 0] += 1.0
    watch(neutral, 10.0, smile, shapes(mouthSmileLeft=0.9, mouthSmileRight=0.9))
    assert (
        neutral.points[CONTROL_POINT_INDEX["outer_lip_corner_l"], 0]
        < MEAN_FACE[CONTROL_POINT_INDEX["outer_lip_corner_l"], 0] + 0.4
    )


def test_the_pose_in_use_never_jumps() -> None:
    neutral = NeutralPoseEstimator()
    used = []
    far = MINE + np.array([0.5, 0.5, 0.0])
    for i in range(3 * FPS):
        neutral.update(MINE if i < FPS else far, shapes(), turn=0.0, timestamp=i / FPS)
        used.append(neutral.blended(i / FPS))
    assert np.abs(np.diff(used, axis=0)).max() < 0.08


def test_a_head_turned_away_counts_for_little() -> None:
    neutral = NeutralPoseEstimator()
    watch(neutral, 1.0, MINE, shapes())
    before = neutral.points
    for i in range(FPS):
        neutral.update(MINE + 1.0, shapes(), turn=np.radians(50), timestamp=1 + i / FPS)
        neutral.blended(1 + i / FPS)
    assert np.abs(neutral.points - before).max() < 0.1


def test_a_pause_is_not_a_long_look() -> None:
    short, long = NeutralPoseEstimator(), NeutralPoseEstimator()
    for neutral, second in ((short, MAX_STEP_S), (long, 3600.0)):
        neutral.update(MEAN_FACE, shapes(), turn=0.0, timestamp=0.0)
        neutral.update(MINE, shapes(), turn=0.0, timestamp=second)
    assert np.allclose(short.blended(0.0), long.blended(0.0))


def test_memory_is_bounded_so_that_a_change_is_learned() -> None:
    neutral = NeutralPoseEstimator()
    watch(neutral, 60.0, MEAN_FACE, shapes())
    watch(neutral, 60.0, MINE, shapes(), start=60.0)
    assert off(neutral, list(range(50))) < 0.25


def test_what_is_taken_is_used_at_once_and_stays() -> None:
    neutral = NeutralPoseEstimator()
    neutral.set(MINE)
    assert neutral.known
    watch(neutral, 5.0, MEAN_FACE, shapes())
    assert np.allclose(neutral.points, MINE)


def test_restart_uses_the_best_that_is_known_at_once() -> None:
    neutral = NeutralPoseEstimator()
    for i in range(FPS):
        neutral.update(MINE, shapes(), turn=0.0, timestamp=i / FPS)
    neutral.reset_clock()
    assert np.abs(neutral.blended(0.0) - MINE).mean() < 0.02


def test_composing_shuts_the_mouth_and_opens_the_eyes_and_leaves_a_composed_face_alone() -> None:
    points, _ = talking(0.125)
    points[control_point_indices("eyelid_upper"), 1] = points[control_point_indices("eyelid_lower"), 1] + 0.05
    composed = close_mouth_open_eyes(points)
    assert lid_gaps(composed) == pytest.approx([MIN_LID_GAP_CM] * 2)
    for at in ("mid", "l", "r"):
        gap = (
            composed[CONTROL_POINT_INDEX[f"inner_lip_upper_{at}"], 1]
            - composed[CONTROL_POINT_INDEX[f"inner_lip_lower_{at}"], 1]
        )
        assert gap <= LIP_GAP_CM + 1e-9
    assert np.allclose(close_mouth_open_eyes(composed), composed)
    assert np.array_equal(composed[BROWS], points[BROWS])
