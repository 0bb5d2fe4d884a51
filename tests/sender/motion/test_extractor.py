from dataclasses import astuple
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from conf.face.control_points import (
    CONTROL_POINT_COUNT,
    CONTROL_POINT_INDEX,
    CONTROL_POINT_LANDMARKS,
    PUPILS,
    control_point_indices,
)
from conf.face.fapu import Fapu
from conf.face.head_pose import HeadPose
from conf.sender.motion.brow_reference import points_with_brows_from_bridge
from conf.sender.motion.expression_offsets import _load_map
from conf.sender.motion.extractor import MotionExtractor, _per_point, off_axis_angle, to_displacements
from conf.sender.motion.mean_face import MEAN_FACE
from conf.sender.motion.neutral_pose import NeutralPoseEstimator
from conf.sender.motion.pre_emphasis import BROW_GAIN_X, LID_GAIN, PUPIL_GAIN_X
from conf.sender.tracking.blendshape_network import INDEX as SHAPE
from conf.sender.tracking.blendshape_network import BlendshapeNetwork
from conf.sender.tracking.canonical_face import FLIP, CanonicalFace, remove_head_pose
from conf.sender.tracking.tracker import TrackedFace
from tests.sender.motion.test_mean_face import points_named
from tests.sender.motion.test_one_euro_filter import ReferenceFilter

SIZE = (320, 240)
NO_SHAPES = _load_map()[1].astype(np.float32)  # of a face without expression
BLINK = NO_SHAPES.copy()
BLINK[[SHAPE["eyeBlinkLeft"], SHAPE["eyeBlinkRight"]]] = 0.8
STRAIGHT = HeadPose(np.zeros(3), np.zeros(2), float(np.log(0.04)))
UPPER_LIDS, LOWER_LIDS = (
    points_named("eyelid_upper_l", "eyelid_upper_r"),
    points_named("eyelid_lower_l", "eyelid_lower_r"),
)


def tracked_face(
    canonical: CanonicalFace,
    points: NDArray[np.float64] = MEAN_FACE,
    *,
    pose: HeadPose = STRAIGHT,
    shapes: NDArray[np.float32] = NO_SHAPES,
    age: int = 0,
) -> TrackedFace:
    """Return the tracked landmarks of a face with these control points, (n, 3) cm, in this pose."""
    face = np.zeros((478, 3))
    face[:468] = canonical.vertices
    free = ~np.isin(CONTROL_POINT_LANDMARKS, canonical.rigid)  # the rigid ones stay canonical: they determine the pose
    face[CONTROL_POINT_LANDMARKS[free]] = points[free]
    image = np.exp(pose.log_scale) * face @ pose.matrix().T
    image[:, :2] += pose.position
    landmarks = image * SIZE[1] * FLIP + [SIZE[0] / 2, SIZE[1] / 2, 0]
    return TrackedFace(landmarks.astype(np.float32), shapes, 1.0, age)


def calibrate(extractor: MotionExtractor, canonical: CanonicalFace, seconds: float = 4.0) -> float:
    """Let the extractor observe a face without expression; return the time after it."""
    steps = round(seconds * 25)
    for i in range(steps):
        extractor.update(tracked_face(canonical), i / 25)
    return steps / 25


def with_lid_gaps(gap_cm: float) -> NDArray[np.float64]:
    points = MEAN_FACE.copy()
    points[UPPER_LIDS, 1] = points[LOWER_LIDS, 1] + gap_cm
    return points


@pytest.mark.slow
def test_a_face_without_expression_has_no_displacements_in_any_pose(canonical: CanonicalFace) -> None:
    extractor = MotionExtractor(canonical, SIZE)
    now = calibrate(extractor, canonical)
    assert extractor.calibrated
    pose = HeadPose(np.array([0.1, 0.3, -0.2]), np.array([0.1, 0.05]), float(np.log(0.03)))
    for i in range(20):
        motion = extractor.update(tracked_face(canonical, pose=pose), now + i / 25)
    assert np.abs(motion.displacements).max() < 5
    assert np.allclose(motion.pose, pose.to_vector(), atol=0.01)
    assert motion.timestamp == now + 19 / 25
    assert motion.displacements.shape == (50, 3)
    assert motion.displacements.dtype == np.float32


@pytest.mark.slow
def test_the_displacement_of_an_opened_mouth(canonical: CanonicalFace) -> None:
    extractor = MotionExtractor(canonical, SIZE)
    now = calibrate(extractor, canonical)
    open_mouth = MEAN_FACE.copy()
    open_mouth[control_point_indices("inner_lip_lower", "outer_lip_lower", "chin"), 1] -= 1.0
    shapes = NO_SHAPES.copy()
    shapes[SHAPE["jawOpen"]] = 0.5
    for i in range(10):
        motion = extractor.update(tracked_face(canonical, open_mouth, shapes=shapes), now + i / 25)
    moved = motion.displacements * extractor.fapu.lengths()
    assert moved[CONTROL_POINT_INDEX["inner_lip_lower_mid"], 1] == pytest.approx(-1.0, abs=0.03)
    assert np.abs(moved[control_point_indices("brow", "inner_lip_upper", "eyelid")]).max() < 0.03


@pytest.mark.slow
def test_a_blink_of_two_frames_shuts_the_eye_of_any_face(canonical: CanonicalFace) -> None:
    extractor = MotionExtractor(canonical, SIZE)
    now = calibrate(extractor, canonical)
    for i in range(2):
        motion = extractor.update(tracked_face(canonical, with_lid_gaps(0.1), shapes=BLINK), now + i / 25)
    receiver = MEAN_FACE * 1.3  # another face
    drawn = receiver + motion.displacements * Fapu.measure(receiver).lengths()
    gaps, neutral_gaps = (points[UPPER_LIDS, 1] - points[LOWER_LIDS, 1] for points in (drawn, receiver))
    assert (np.abs(gaps) < 0.05 * neutral_gaps).all()
    for i in range(3):
        motion = extractor.update(tracked_face(canonical), now + (2 + i) / 25)
    assert abs(motion.displacements[control_point_indices("eyelid"), 1]).max() < 60  # open again at once


@pytest.mark.slow
def test_blinks_teach_the_gap_of_shut_lids(canonical: CanonicalFace) -> None:
    extractor = MotionExtractor(canonical, SIZE)
    now = calibrate(extractor, canonical)
    gap = float((MEAN_FACE[UPPER_LIDS, 1] - MEAN_FACE[LOWER_LIDS, 1])[0])
    before = extractor.fapu.irisd0
    for i in range(100):
        motion = extractor.update(tracked_face(canonical, with_lid_gaps(0.25 * gap), shapes=BLINK), now + i / 25)
    assert extractor.fapu.irisd0 / before == pytest.approx((1 - 0.25) / (1 - 0.16), rel=0.015)
    lids = motion.displacements[UPPER_LIDS, 1] - motion.displacements[LOWER_LIDS, 1]
    assert lids == pytest.approx([-1024, -1024], abs=5)


@pytest.mark.parametrize(
    ("prefix", "min_cutoff", "beta"),
    [
        ("inner_lip_lower", 5.0, 6.0),
        ("outer_lip_lower", 5.0, 6.0),
        ("cupids_bow", 5.0, 6.0),
        ("eyelid_upper", 6.0, 20.0),
        ("eyelid_lower", 6.0, 20.0),
        ("pupil", 4.0, 6.0),
        ("brow_top", 3.0, 3.0),
        ("chin_boss", 2.0, 3.0),
    ],
)
def test_each_group_of_points_has_its_own_filter(
    canonical: CanonicalFace, prefix: str, min_cutoff: float, beta: float
) -> None:
    extractor, points = MotionExtractor(canonical, SIZE), control_point_indices(prefix)
    assert not np.isin(CONTROL_POINT_LANDMARKS[points], canonical.rigid).any()
    extractor.set_neutral_now()
    reference = ReferenceFilter(min_cutoff, beta)
    for i, step in enumerate((0.0, 0.2, 0.2, 0.3)):
        moved = MEAN_FACE.copy()
        moved[points, 0] += step
        motion = extractor.update(tracked_face(canonical, moved), i / 25)
        expected = reference.smooth(step, i / 25) * {"pupil": PUPIL_GAIN_X, "brow_top": BROW_GAIN_X}.get(prefix, 1.0)
        found = (motion.displacements * extractor.fapu.lengths())[points, 0]
        assert found == pytest.approx([expected] * len(points), abs=2e-4)


@pytest.mark.parametrize(
    ("component", "min_cutoff", "beta"),
    [(0, 1.4, 120.0), (1, 1.4, 120.0), (2, 1.4, 120.0), (3, 2.8, 360.0), (4, 2.8, 360.0), (5, 1.4, 120.0)],
)
def test_each_component_of_the_pose_has_its_own_filter(
    canonical: CanonicalFace, component: int, min_cutoff: float, beta: float
) -> None:
    extractor, reference = MotionExtractor(canonical, SIZE), ReferenceFilter(min_cutoff, beta)
    for i, step in enumerate((0.0, 0.004, 0.004, 0.006)):
        pose = STRAIGHT.to_vector()
        pose[component] += step
        motion = extractor.update(tracked_face(canonical, pose=HeadPose.from_vector(pose)), i / 25)
        found = motion.pose[component] - STRAIGHT.to_vector()[component]
        assert found == pytest.approx(reference.smooth(step, i / 25), abs=2e-5)


def test_displacements_are_in_units_of_the_face() -> None:
    fapu = Fapu.measure(MEAN_FACE)
    moved = MEAN_FACE.copy()
    point = CONTROL_POINT_INDEX["outer_lip_corner_l"]
    moved[point] += (0.1, -0.2, 0.3)
    units = to_displacements(moved, MEAN_FACE, fapu, np.ones(2))
    assert units[point] == pytest.approx(np.array([0.1, -0.2, 0.3]) * 1024 / (fapu.mw0, fapu.mns0, fapu.mw0))
    units[point] = 0
    assert np.allclose(units, 0)


def test_pupils_are_measured_relative_to_their_own_eye() -> None:
    fapu = Fapu.measure(MEAN_FACE)
    moved = MEAN_FACE.copy()
    moved[points_named("eye_inner_corner_l", "eye_outer_corner_l", "pupil_l")] += (
        0.2,
        0.1,
        0.0,
    )  # the whole eye shifts
    moved[points_named("pupil_r")] += (0.3, 0.0, 0.4)  # the eyeball rotates
    units = to_displacements(moved, MEAN_FACE, fapu, np.ones(2))
    assert np.allclose(units[CONTROL_POINT_INDEX["pupil_l"]], 0)
    assert units[CONTROL_POINT_INDEX["pupil_r"]] == pytest.approx([PUPIL_GAIN_X * 0.3 / fapu.es0 * 1024, 0, 0])


def test_the_openness_places_the_upper_lid_over_the_lower_one() -> None:
    moved = MEAN_FACE.copy()
    moved[LOWER_LIDS, 1] += 0.1
    units = to_displacements(moved, MEAN_FACE, Fapu.measure(MEAN_FACE), np.array([0.25, 1.5]))
    assert units[LOWER_LIDS, 1].min() > 0
    assert units[UPPER_LIDS, 1] - units[LOWER_LIDS, 1] == pytest.approx([-768 * LID_GAIN, 512 * LID_GAIN])


def test_the_first_face_is_the_neutral_pose_if_set_before(canonical: CanonicalFace) -> None:
    extractor = MotionExtractor(canonical, SIZE)
    raised = MEAN_FACE.copy()
    raised[control_point_indices("brow"), 1] += 0.5
    extractor.set_neutral_now()
    motion = extractor.update(tracked_face(canonical, raised), 0.0)
    assert extractor.calibrated
    assert np.abs(motion.displacements[control_point_indices("brow")]).max() < 1
    for i in range(1, 30):
        motion = extractor.update(tracked_face(canonical), i / 25)
    assert np.abs(motion.displacements[control_point_indices("brow"), 1]).min() > 100  # it stays the neutral pose


def test_the_last_face_becomes_the_neutral_pose_at_once(canonical: CanonicalFace) -> None:
    extractor = MotionExtractor(canonical, SIZE)
    raised = MEAN_FACE.copy()
    raised[control_point_indices("brow"), 1] += 0.5
    for i in range(30):
        extractor.update(tracked_face(canonical, raised, age=1), i / 25)
    assert not extractor.calibrated
    extractor.set_neutral_now()
    assert extractor.calibrated
    aligned, _ = remove_head_pose(tracked_face(canonical, raised).landmarks, canonical, SIZE)
    brows = control_point_indices("brow")
    assert extractor.neutral_points[brows, 1] == pytest.approx(
        points_with_brows_from_bridge(aligned)[brows, 1], abs=0.01
    )


def test_old_blendshapes_are_not_learned_from(canonical: CanonicalFace) -> None:
    extractor = MotionExtractor(canonical, SIZE)
    for i in range(50):
        extractor.update(tracked_face(canonical, age=1), i / 25)
    assert not extractor.calibrated


@pytest.mark.slow
def test_restart_keeps_the_neutral_pose(canonical: CanonicalFace) -> None:
    extractor = MotionExtractor(canonical, SIZE)
    calibrate(extractor, canonical)
    before = astuple(extractor.fapu)
    extractor.restart()
    motion = extractor.update(tracked_face(canonical), 0.0)
    assert astuple(extractor.fapu) == pytest.approx(before, rel=0.01)
    assert np.abs(motion.displacements).max() < 5


def test_restart_resets_the_filters_and_the_clock(canonical: CanonicalFace) -> None:
    extractor = MotionExtractor(canonical, SIZE)
    now = calibrate(extractor, canonical, 0.2)
    neutral = extractor.neutral_points
    extractor.restart()
    pose = HeadPose(STRAIGHT.rotation, np.array([0.02, 0.0]), STRAIGHT.log_scale)
    moved = MEAN_FACE.copy()
    moved[control_point_indices("brow"), 0] += 0.2
    motion = extractor.update(tracked_face(canonical, moved, pose=pose, age=1), now)
    assert motion.pose[3] == pytest.approx(0.02, abs=1e-5)
    neutral_after = extractor.neutral_points  # the estimate itself, no longer blended
    brow = CONTROL_POINT_INDEX["brow_top_l"]
    assert abs(neutral_after - neutral).max() > 0
    found = motion.displacements[brow, 0] * extractor.fapu.lengths()[brow, 0]
    assert found == pytest.approx(BROW_GAIN_X * (moved[brow, 0] - neutral_after[brow, 0]), abs=1e-3)


def test_the_angle_between_the_head_and_the_camera() -> None:
    assert off_axis_angle(STRAIGHT) == 0
    for angle in (0.5, 1.5, 3.0):
        assert off_axis_angle(HeadPose(np.array([0.0, angle, 0.0]), np.zeros(2), 0.0)) == pytest.approx(angle)
    rolled = HeadPose(np.array([0.0, 0.0, 0.5]), np.zeros(2), 0.0)
    assert off_axis_angle(rolled) == pytest.approx(0, abs=1e-7)


def gap(landmarks: NDArray[np.float32], a: int, b: int) -> float:
    """Return the distance of two landmarks in the image over that of the outer eye corners."""
    return float(np.linalg.norm(landmarks[a, :2] - landmarks[b, :2]) / np.linalg.norm(landmarks[33] - landmarks[263]))


@pytest.mark.slow
@pytest.mark.parametrize("clip", ["cap12", "grid_bbaf2n", "talk_4", "woman_hand_over_face"])
def test_motion_of_real_people_follows_the_landmarks(
    models: Path, canonical: CanonicalFace, shared: Path, clip: str
) -> None:
    track = np.load(shared / "motion" / f"{clip}.npz")
    fps, size = float(track["fps"]), (int(track["width"]), int(track["height"]))
    network = BlendshapeNetwork(models)
    extractor = MotionExtractor(canonical, size)
    upper_lip, lower_lip, upper_lid, lower_lid = points_named(
        "inner_lip_upper_mid", "inner_lip_lower_mid", "eyelid_upper_l", "eyelid_lower_l"
    )
    rows = []
    for i, landmarks in enumerate((track["landmarks"][:200] / track["scale"]).astype(np.float32)):
        up = extractor.update(TrackedFace(landmarks, network.predict(landmarks), 1.0), i / fps).displacements[:, 1]
        gaps = gap(landmarks, 13, 14), gap(landmarks, 386, 374)
        rows.append([up[upper_lip] - up[lower_lip], up[upper_lid] - up[lower_lid], *gaps])
    mouth, lid, mouth_gap, lid_gap = np.array(rows)[25:].T  # after the first second
    assert np.corrcoef(mouth, mouth_gap)[0, 1] > 0.97
    assert np.corrcoef(lid, lid_gap)[0, 1] > 0.9
    assert np.isfinite(rows).all()
    assert lid.min() >= -1024


def test_a_value_per_point_is_the_default_but_for_the_named_points() -> None:
    values = _per_point(1.5, pupil=4.0, eyelid=6.0)
    assert values.shape == (CONTROL_POINT_COUNT, 1)
    assert set(values[PUPILS].ravel()) == {4.0}
    assert set(values[control_point_indices("eyelid")].ravel()) == {6.0}
    others = np.delete(values, [*PUPILS, *control_point_indices("eyelid")])
    assert len(others) > 30 and set(others) == {1.5}


def test_an_estimator_of_the_neutral_pose_can_be_given(canonical: CanonicalFace) -> None:
    neutral = NeutralPoseEstimator()
    neutral.set(MEAN_FACE + 0.1)
    extractor = MotionExtractor(canonical, SIZE, neutral=neutral)
    extractor.update(tracked_face(canonical), 0.0)
    assert extractor.calibrated
    assert np.array_equal(extractor.neutral_points, neutral.points)
