"""Furrows are vertical lines between the brows, whatever light, size and pose, beyond those that a face has at rest."""

from collections.abc import Sequence

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from conf.face.head_pose import HeadPose
from conf.protocol.messages import MotionFrame
from conf.sender.motion.furrows import (
    BEGIN_ABOVE,
    CALM_DOUBLE_S,
    DOUBLE_S,
    GLABELLA,
    MIN_PX_PER_CM,
    QUIET,
    SPAN,
    FurrowEstimator,
    furrow_energy,
)
from conf.sender.tracking.blendshape_network import INDEX as SHAPE
from conf.sender.tracking.tracker import TrackedFace

SIZE = (400, 300)
FRAME_S = 1 / 15
STILL, FROWN = 0.8, 3.5  # percent


def head(*, scale: float = 14.0, yaw: float = 0.0, roll: float = 0.0) -> HeadPose:
    """Return a pose in the middle of the image. scale : px a centimetre"""
    return HeadPose(np.array([0.0, yaw, roll]), np.zeros(2), float(np.log(scale / SIZE[1])))


def paint(
    pose: HeadPose, *, vertical: float = 0.0, horizontal: float = 0.0, left: float = 0.0, light: float = 1.0
) -> NDArray[np.uint8]:
    """Return an image of skin with dark lines of these depths, 0 to 1, in the middle, or to the left of it."""
    rows, columns = np.mgrid[: SIZE[1], : SIZE[0]]
    offsets = np.stack([columns - SIZE[0] / 2, SIZE[1] / 2 - rows], axis=-1)
    in_face = np.linalg.inv(pose.matrix()[:2, :2] * np.exp(pose.log_scale) * SIZE[1])
    x, y = np.moveaxis(offsets @ in_face.T, -1, 0)
    lines = vertical * np.exp(-(((np.abs(x) - 0.45) / 0.13) ** 2))
    lines += horizontal * np.exp(-(((y - 0.3) / 0.13) ** 2)) + left * np.exp(-(((x - 0.45) / 0.13) ** 2))
    brightness = 150 * light * (1 - lines) * (1 + 0.03 * x + 0.02 * y)
    return np.repeat(np.clip(np.rint(brightness), 0, 255).astype(np.uint8)[..., None], 3, axis=2)


def landmarks(x: float = SIZE[0] / 2, y: float = SIZE[1] / 2) -> NDArray[np.float32]:
    points = np.zeros((478, 3), np.float32)
    points[GLABELLA] = x, y, 0.0
    return points


def energy(pose: HeadPose, pixels: NDArray[np.uint8]) -> float:
    found = furrow_energy(pixels, landmarks(), pose)
    assert found is not None
    return found


def test_only_vertical_lines_on_both_sides_are_furrows() -> None:
    pose = head()
    assert energy(pose, paint(pose)) < 0.4
    assert energy(pose, paint(pose, horizontal=0.3)) < 0.5
    assert energy(pose, paint(pose, left=0.4)) < 0.35 * energy(pose, paint(pose, vertical=0.4)), "a strand of hair"
    assert energy(pose, paint(pose, vertical=0.15)) > 2.0
    assert energy(pose, paint(pose, vertical=0.3)) > 1.7 * energy(pose, paint(pose, vertical=0.15))


@pytest.mark.parametrize("light", [0.4, 0.7, 1.6])
def test_the_light_does_not_matter(light: float) -> None:
    pose = head()
    expected = energy(pose, paint(pose, vertical=0.2))
    assert energy(pose, paint(pose, vertical=0.2, light=light)) == pytest.approx(expected, rel=0.15)


@pytest.mark.parametrize(
    "pose", [head(scale=8), head(scale=25), head(yaw=0.3), head(roll=0.4), head(scale=20, yaw=-0.2, roll=-0.3)]
)
def test_size_and_pose_do_not_matter(pose: HeadPose) -> None:
    expected = energy(head(), paint(head(), vertical=0.2))
    assert energy(pose, paint(pose, vertical=0.2)) == pytest.approx(expected, rel=0.15)


def test_a_face_that_is_too_small_or_cut_off_shows_no_furrows() -> None:
    pose = head()
    pixels = paint(pose, vertical=0.3)
    assert furrow_energy(pixels, landmarks(), head(scale=0.9 * MIN_PX_PER_CM)) is None
    for x, y in ((5, 150), (395, 150), (200, 5), (200, 295), (-900, 150), (200, 9000)):
        assert furrow_energy(pixels, landmarks(x, y), pose) is None


def run(
    estimator: FurrowEstimator, energies: Sequence[float | None], begin: float = 0.0, *, calm: float = 1.0
) -> list[float]:
    return [estimator.update(value, begin + number * FRAME_S, calm=calm) for number, value in enumerate(energies)]


def test_a_frown_is_deep_and_a_face_at_rest_has_none() -> None:
    estimator = FurrowEstimator()
    depths = run(estimator, [STILL] * 90 + [FROWN] * 30 + [STILL] * 30)
    assert max(depths[:90]) == 0.0 and depths[105] > 0.9 and depths[-1] < 0.01


def test_lines_of_a_face_at_rest_are_none_even_before_they_are_known() -> None:
    assert max(run(FurrowEstimator(), [QUIET + BEGIN_ABOVE] * 900)) == 0.0


@pytest.mark.parametrize(("calm", "are_always_there"), [(1.0, True), (0.0, False)])
def test_a_calm_face_that_comes_with_lines_has_none_until_they_were_gone(calm: float, are_always_there: bool) -> None:
    estimator = FurrowEstimator()
    deepest = max(run(estimator, [FROWN] * 60, calm=calm))
    assert deepest == 0.0 if are_always_there else deepest > 0.5
    depths = run(estimator, [STILL] * 150 + [FROWN] * 30, 2.0, calm=calm)
    assert max(depths[30:150]) < 0.01 and depths[-1] > 0.9


@pytest.mark.parametrize(("calm", "double_s"), [(1.0, CALM_DOUBLE_S), (0.0, DOUBLE_S)])
def test_lines_that_stay_become_the_quiet_level_sooner_on_a_face_at_rest(calm: float, double_s: float) -> None:
    estimator = FurrowEstimator()
    run(estimator, [STILL] * 150)
    lines = [STILL + BEGIN_ABOVE + SPAN / 2] * round(2 * double_s / FRAME_S)
    depths = run(estimator, lines, 10.0, calm=calm)
    assert depths[15] > 0.4 and depths[-1] == pytest.approx(0.0, abs=1e-3)


def test_what_is_not_seen_fades_and_is_not_learned() -> None:
    estimator = FurrowEstimator()
    run(estimator, [STILL] * 90 + [FROWN] * 15)
    depths = run(estimator, [None] * 900, 7.0)
    assert depths[0] > 0.3 and depths[15] < 0.02
    assert run(estimator, [FROWN] * 15, 67.0)[-1] > 0.9


@given(st.lists(st.none() | st.floats(0, 100), max_size=40), st.lists(st.floats(-5, 5), min_size=40, max_size=40))
def test_any_measurements_at_any_times_give_a_depth(energies: list[float | None], times: list[float]) -> None:
    estimator = FurrowEstimator()
    for value, at in zip(energies, times, strict=False):
        assert 0.0 <= estimator.update(value, at) <= 1.0


@pytest.mark.parametrize(("yaw", "is_seen"), [(0.0, True), (0.3, True), (0.6, False)])
def test_the_motion_of_a_face_that_looks_away_has_no_furrows(yaw: float, is_seen: bool) -> None:
    pose, estimator = head(yaw=yaw), FurrowEstimator()
    tracked = TrackedFace(landmarks(), np.zeros(52, np.float32), 1.0)
    smooth, folded = paint(pose), paint(pose, vertical=0.4)
    for number in range(75):
        pixels = folded if number >= 60 else smooth
        motion = MotionFrame(number * FRAME_S, np.zeros((50, 3), np.float32), pose.to_vector())
        found = estimator.add_furrows(motion, tracked, pixels)
        assert found.timestamp == motion.timestamp and found.displacements is motion.displacements
        assert number >= 60 or found.furrow == 0.0
    assert (found.furrow > 0.3) is is_seen and is_seen is (found.furrow > 0.0)


@pytest.mark.parametrize(("shape", "is_seen"), [(None, False), ("eyeBlinkLeft", True), ("browDownRight", True)])
def test_furrows_of_a_face_that_is_at_rest_otherwise_soon_are_its_own(shape: str | None, is_seen: bool) -> None:
    pose, estimator, shapes = head(), FurrowEstimator(), np.zeros(52, np.float32)
    if shape:
        shapes[SHAPE[shape]] = 0.7
    pixels, tracked = paint(pose, vertical=0.22), TrackedFace(landmarks(), shapes, 1.0)
    for number in range(round(1.5 * CALM_DOUBLE_S / FRAME_S)):
        motion = MotionFrame(number * FRAME_S, np.zeros((50, 3), np.float32), pose.to_vector())
        depth = estimator.add_furrows(motion, tracked, pixels).furrow
    assert (depth > 0.1) is is_seen
