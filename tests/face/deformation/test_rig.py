import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.face.control_points import PUPILS
from conf.face.deformation.rig import CHIN, JAW_RANGE, MAX_GAZE, Eye, Jaw, cross_matrix, gaze_rotation, jaw_offsets
from tests.support.sheet_face import SheetFace

small = st.floats(-5, 5)
AXIS = np.array([1.0, 0.0, 0.0])


@pytest.mark.slow
@given(small, small)
def test_gaze_rotations_are_proper_and_limited(x: float, y: float) -> None:
    pupil = np.array([0.1, -0.2, 1.7])
    rotation = gaze_rotation(pupil, np.array([x, y, 9.0]))
    assert rotation @ rotation.T == pytest.approx(np.eye(3), abs=1e-9)
    rotated = rotation @ pupil
    assert np.linalg.norm(rotated) == pytest.approx(np.linalg.norm(pupil))
    assert np.hypot(*rotated[:2]) <= np.sin(MAX_GAZE) * np.linalg.norm(pupil) + 1e-9


@pytest.mark.slow
@given(st.floats(-0.6, 0.6), st.floats(-0.6, 0.6))
def test_the_pupil_is_rotated_to_its_displaced_position(x: float, y: float) -> None:
    pupil = np.array([0.1, -0.2, 1.7])
    rotated = gaze_rotation(pupil, np.array([x, y, 0.0])) @ pupil
    assert rotated[:2] == pytest.approx(pupil[:2] + np.array([x, y]))
    assert rotated[2] > 0


def test_a_zero_offset_gives_the_identity() -> None:
    assert gaze_rotation(np.array([0.1, -0.2, 1.7]), np.zeros(3)) == pytest.approx(np.eye(3))


def test_lids_are_pushed_out_of_the_eyeball() -> None:
    centre = np.array([3.0, 2.0, 1.0])
    eye = Eye(centre, PUPILS[0], np.array([0]), np.array([1, 2, 3]), np.array([1.3, 1.3, 0.4], dtype=np.float32))
    neutral = (centre + np.array([[0, 0, 1.2], [0, 1.4, 0.2], [0, 1.5, 0], [0, 0.4, 0]])).astype(np.float32)
    moved = neutral.copy()
    moved[1:] = centre + np.array([[0, 0, 0.9], [0, 0, 2.0], [0.2, 0, 0]])
    points = np.tile(neutral[0].astype(float), (50, 1))
    eye.apply(neutral, moved, points, np.zeros((50, 3)))
    from_centre = moved - centre
    assert from_centre[0] == pytest.approx([0, 0, 1.2])
    assert from_centre[1] == pytest.approx([0, 0, 1.3], abs=1e-6)  # was inside: moved to the surface
    assert from_centre[2] == pytest.approx([0, 0, 2.0], abs=1e-6)  # was outside: unchanged
    assert from_centre[3] == pytest.approx([0.4, 0, 0], abs=1e-6)  # no deeper than in the neutral pose


def jaw(face: SheetFace) -> Jaw:
    centre = np.array([0.0, 0.0, -4.0])
    weights = np.zeros(50, dtype=np.float32)
    weights[CHIN] = 1.0
    arms = (face.points - centre).astype(np.float32) * weights[:, None]
    return Jaw(centre, AXIS, np.arange(50), weights, arms, weights, arms)


@pytest.mark.slow
@given(st.floats(JAW_RANGE[0], JAW_RANGE[1]), st.floats(-1, 1))
def test_the_jaws_motion_is_recovered_from_the_chin(face: SheetFace, angle: float, translation: float) -> None:
    hinge = jaw(face)
    cross = cross_matrix(AXIS)
    rotation = np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
    offsets = (face.points - hinge.centre) @ rotation.T + translation * AXIS
    motion = hinge.estimate_motion(face.points, offsets)
    assert motion[0] == pytest.approx(rotation, abs=1e-5)
    assert motion[1] == pytest.approx(translation * AXIS, abs=1e-5)
    assert jaw_offsets(hinge.weighted_offsets, hinge.weights, motion)[CHIN] == pytest.approx(offsets[CHIN], abs=1e-4)


def test_opening_moves_the_chin_down_and_back(face: SheetFace) -> None:
    hinge = jaw(face)
    offsets = np.zeros((50, 3))
    offsets[CHIN] = [0, -2.5, -2.0]
    moved = jaw_offsets(hinge.weighted_offsets, hinge.weights, hinge.estimate_motion(face.points, offsets))[CHIN[0]]
    assert moved[1] < -1.5
    assert moved[2] < -1


def test_the_jaw_angle_is_limited(face: SheetFace) -> None:
    hinge = jaw(face)
    for down, expected in ((5.0, JAW_RANGE[0]), (-500.0, JAW_RANGE[1])):
        offsets = np.zeros((50, 3))
        offsets[CHIN, 1] = down
        rotation, _ = hinge.estimate_motion(face.points, offsets)
        assert np.arcsin(rotation[2, 1]) == pytest.approx(expected)
