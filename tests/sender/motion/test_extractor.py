from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_INDEX, CONTROL_POINT_LANDMARKS, control_point_indices
from conf.face.fapu import Fapu
from conf.face.head_pose import HeadPose
from conf.sender.motion.extractor import MotionExtractor, off_axis_angle, to_displacements
from conf.sender.motion.mean_face import MEAN_FACE
from conf.sender.tracking.blendshape_network import INDEX as SHAPE
from conf.sender.tracking.blendshape_network import BlendshapeNetwork
from conf.sender.tracking.canonical_face import CanonicalFace
from conf.sender.tracking.pose_removal import FLIP
from conf.sender.tracking.tracker import TrackedFace

SIZE = (320, 240)
QUIET = np.zeros(52, np.float32)
STRAIGHT = HeadPose(np.zeros(3), np.zeros(2), float(np.log(0.04)))


def tracking(
    canonical: CanonicalFace,
    points: NDArray[np.float64],
    *,
    pose: HeadPose = STRAIGHT,
    shapes: NDArray[np.float32] = QUIET,
) -> TrackedFace:
    """What the tracker would say of a face with these control points, (n, 3) cm, in this pose."""
    face = np.zeros((478, 3))
    face[:468] = canonical.vertices
    free = ~np.isin(
        CONTROL_POINT_LANDMARKS, canonical.rigid
    )  # the pose is found by the rigid ones: they stay canonical
    face[CONTROL_POINT_LANDMARKS[free]] = points[free]
    picture = np.exp(pose.log_scale) * face @ pose.matrix().T
    picture[:, :2] += pose.position
    landmarks = picture * SIZE[1] * FLIP + [SIZE[0] / 2, SIZE[1] / 2, 0]
    return TrackedFace(landmarks.astype(np.float32), shapes, 1.0)


def settle(extractor: MotionExtractor, canonical: CanonicalFace, seconds: float = 4.0) -> float:
    """Let the extractor watch a quiet face; return the time after it."""
    steps = round(seconds * 25)
    for i in range(steps):
        extractor.update(tracking(canonical, MEAN_FACE), i / 25)
    return steps / 25


def test_a_quiet_face_moves_nothing_whatever_its_pose(canonical: CanonicalFace) -> None:
    extractor = MotionExtractor(canonical, SIZE)
    now = settle(extractor, canonical)
    assert extractor.calibrated
    pose = HeadPose(np.array([0.1, 0.3, -0.2]), np.array([0.1, 0.05]), float(np.log(0.03)))
    for i in range(20):
        motion = extractor.update(tracking(canonical, MEAN_FACE, pose=pose), now + i / 25)
    assert np.abs(motion.displacements).max() < 5
    assert np.allclose(motion.pose, pose.to_vector(), atol=0.01)
    assert motion.timestamp == now + 19 / 25
    assert motion.displacements.shape == (50, 3)
    assert motion.displacements.dtype == np.float32


def test_a_mouth_opens_by_what_it_opens(canonical: CanonicalFace) -> None:
    extractor = MotionExtractor(canonical, SIZE)
    now = settle(extractor, canonical)
    open_mouth = MEAN_FACE.copy()
    open_mouth[control_point_indices("inner_lip_lower", "outer_lip_lower", "chin"), 1] -= 1.0
    shapes = QUIET.copy()
    shapes[SHAPE["jawOpen"]] = 0.5
    for i in range(10):
        motion = extractor.update(tracking(canonical, open_mouth, shapes=shapes), now + i / 25)
    moved = motion.displacements * extractor.fapu.lengths()
    assert moved[CONTROL_POINT_INDEX["inner_lip_lower_mid"], 1] == pytest.approx(-1.0, abs=0.03)
    assert np.abs(moved[control_point_indices("brow", "inner_lip_upper", "eyelid")]).max() < 0.03


def test_a_blink_of_two_frames_shuts_the_eye_on_any_face(canonical: CanonicalFace) -> None:
    extractor = MotionExtractor(canonical, SIZE)
    now = settle(extractor, canonical)
    shut = MEAN_FACE.copy()
    shut[control_point_indices("eyelid_upper"), 1] = shut[control_point_indices("eyelid_lower"), 1] + 0.1
    shapes = QUIET.copy()
    shapes[[SHAPE["eyeBlinkLeft"], SHAPE["eyeBlinkRight"]]] = 0.8
    for i in range(2):
        motion = extractor.update(tracking(canonical, shut, shapes=shapes), now + i / 25)
    receiver = MEAN_FACE * 1.3  # another face: the lids must meet on it
    units = Fapu.measure(receiver).lengths()
    drawn = receiver + motion.displacements * units
    for side in "lr":
        gap = (
            drawn[CONTROL_POINT_INDEX[f"eyelid_upper_{side}"], 1]
            - drawn[CONTROL_POINT_INDEX[f"eyelid_lower_{side}"], 1]
        )
        usual = (
            receiver[CONTROL_POINT_INDEX[f"eyelid_upper_{side}"], 1]
            - receiver[CONTROL_POINT_INDEX[f"eyelid_lower_{side}"], 1]
        )
        assert abs(gap) < 0.05 * usual
    for i in range(3):
        motion = extractor.update(tracking(canonical, MEAN_FACE), now + (2 + i) / 25)
    assert abs(motion.displacements[control_point_indices("eyelid"), 1]).max() < 60  # and open again at once


def test_pupils_are_measured_from_their_own_eye() -> None:
    fapu = Fapu.measure(MEAN_FACE)
    moved = MEAN_FACE.copy()
    moved[control_point_indices("eye_inner_corner_l", "eye_outer_corner_l", "pupil_l")] += [
        0.2,
        0.1,
        0.0,
    ]  # the eye shifts as a whole
    moved[control_point_indices("pupil_r"), 0] += 0.3  # the eyeball turns
    units = to_displacements(moved, MEAN_FACE, fapu, np.ones(2))
    assert np.allclose(units[CONTROL_POINT_INDEX["pupil_l"]], 0)
    assert units[CONTROL_POINT_INDEX["pupil_r"]] == pytest.approx([0.3 / fapu.es0 * 1024, 0, 0])


def test_calibrate_now_takes_the_face_as_it_is(canonical: CanonicalFace) -> None:
    extractor = MotionExtractor(canonical, SIZE)
    raised = MEAN_FACE.copy()
    raised[control_point_indices("brow"), 1] += 0.5
    extractor.set_neutral_now()  # before there is a face: the first will do
    motion = extractor.update(tracking(canonical, raised), 0.0)
    assert extractor.calibrated
    assert np.abs(motion.displacements[control_point_indices("brow")]).max() < 1
    for i in range(1, 30):
        extractor.update(tracking(canonical, MEAN_FACE), i / 25)
    extractor.set_neutral_now()
    motion = extractor.update(tracking(canonical, MEAN_FACE), 30 / 25)
    assert np.abs(motion.displacements[control_point_indices("brow")]).max() < 5


def test_old_blendshapes_teach_nothing(canonical: CanonicalFace) -> None:
    extractor = MotionExtractor(canonical, SIZE)
    for i in range(50):
        seen = tracking(canonical, MEAN_FACE)
        extractor.update(TrackedFace(seen.landmarks, seen.blendshapes, 1.0, blendshapes_age=1), i / 25)
    assert not extractor.calibrated


def test_restart_keeps_the_neutral_pose(canonical: CanonicalFace) -> None:
    extractor = MotionExtractor(canonical, SIZE)
    settle(extractor, canonical)
    before = extractor.fapu_distances()
    extractor.restart()
    motion = extractor.update(tracking(canonical, MEAN_FACE), 0.0)
    assert extractor.fapu_distances() == pytest.approx(before, rel=0.01)
    assert np.abs(motion.displacements).max() < 5


def test_turn_is_the_angle_of_the_nose_to_the_camera() -> None:
    assert off_axis_angle(STRAIGHT) == 0
    aside = HeadPose(np.array([0.0, 0.5, 0.0]), np.zeros(2), 0.0)
    rolled = HeadPose(np.array([0.0, 0.0, 0.5]), np.zeros(2), 0.0)
    assert off_axis_angle(aside) == pytest.approx(0.5)
    assert off_axis_angle(rolled) == pytest.approx(0, abs=1e-7)


def gap(landmarks: NDArray[np.float32], a: int, b: int) -> float:
    """The distance of two landmarks in the picture over that of the outer eye corners."""
    return float(np.linalg.norm(landmarks[a, :2] - landmarks[b, :2]) / np.linalg.norm(landmarks[33] - landmarks[263]))


@pytest.mark.parametrize("clip", ["cap12", "grid_bbaf2n", "talk_4", "woman_hand_over_face"])
def test_motion_of_real_people_follows_what_the_tracker_saw(
    models: Path, canonical: CanonicalFace, shared: Path, clip: str
) -> None:
    track = np.load(shared / "motion" / f"{clip}.npz")
    fps, size = float(track["fps"]), (int(track["width"]), int(track["height"]))
    finder = BlendshapeNetwork(models)
    extractor = MotionExtractor(canonical, size)
    rows = []
    for i, landmarks in enumerate((track["landmarks"][:200] / track["scale"]).astype(np.float32)):
        seen = TrackedFace(landmarks, finder.predict(landmarks), 1.0)
        moved = extractor.update(seen, i / fps).displacements
        mouth = (
            moved[CONTROL_POINT_INDEX["inner_lip_upper_mid"], 1] - moved[CONTROL_POINT_INDEX["inner_lip_lower_mid"], 1]
        )
        lid = moved[CONTROL_POINT_INDEX["eyelid_upper_l"], 1] - moved[CONTROL_POINT_INDEX["eyelid_lower_l"], 1]
        rows.append([mouth, gap(landmarks, 13, 14), lid, gap(landmarks, 386, 374)])
    mouth, mouth_gap, lid, lid_gap = np.array(rows)[25:].T  # after the first second
    assert np.corrcoef(mouth, mouth_gap)[0, 1] > 0.97
    assert np.corrcoef(lid, lid_gap)[0, 1] > 0.9
    assert np.isfinite(rows).all()
    assert lid.min() >= -1024
