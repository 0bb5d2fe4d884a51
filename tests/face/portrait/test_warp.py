import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.face.control_points import (
    CONTROL_POINT_COUNT,
    CONTROL_POINT_INDEX,
    LOWER_LID,
    LOWER_LIP,
    PUPILS,
    UPPER_LIP,
    control_point_indices,
)
from conf.face.fapu import UNITS_PER_DISTANCE
from conf.face.head_pose import HeadPose
from conf.face.portrait import contours
from conf.face.portrait.photo_mesh import signed_areas
from conf.face.portrait.photographed_face import project
from conf.face.portrait.warp import (
    MAX_ROTATION,
    NECK_GROWTH,
    NECK_REACH_CM,
    PortraitWarp,
    limit_rotation,
    split_photo_regions,
)
from tests.support.synthetic_portrait import POSE, face_points, face_shape

WARP = PortraitWarp(face_shape())
MIN_STRETCH, MAX_STRETCH = 0.45, 1.65  # of a triangle in any direction: beyond it looks smeared
STILL = np.zeros((CONTROL_POINT_COUNT, 3))


def test_the_photos_own_displacements_reproduce_it() -> None:
    np.testing.assert_allclose(WARP.deform(WARP.photo_displacements(), POSE), WARP.mesh.positions, atol=2e-5)


def test_control_points_follow_the_motion() -> None:
    displacements = STILL.copy()
    displacements[CONTROL_POINT_INDEX["outer_lip_corner_l"], 0] = 150
    displacements[CONTROL_POINT_INDEX["brow_top_r"], 1] = 100
    pose = HeadPose(POSE.rotation + np.array((0.05, 0.1, 0.1)), POSE.position + 0.05, POSE.log_scale + 0.05)
    positions = WARP.deform(displacements, pose)[:CONTROL_POINT_COUNT]
    np.testing.assert_allclose(positions, project(WARP.control_points(displacements), pose), atol=2e-3)


def test_displacements_are_those_that_yield_the_control_points() -> None:
    moved = np.random.default_rng(1).normal(0, 60, (CONTROL_POINT_COUNT, 3))
    moved[control_point_indices("eyelid"), 1] = 0.0  # the gap of closing lids is not sent
    moved[list(PUPILS), 2] = 0.0  # nor the depth of pupils
    np.testing.assert_allclose(WARP.displacements(WARP.control_points(moved)), moved, atol=1e-9)


def test_closed_lids_meet() -> None:
    closed = STILL.copy()
    closed[[CONTROL_POINT_INDEX["eyelid_upper_l"], CONTROL_POINT_INDEX["eyelid_upper_r"]], 1] = -UNITS_PER_DISTANCE
    points = WARP.control_points(closed)
    for side in "lr":
        upper, lower = (points[CONTROL_POINT_INDEX[f"eyelid_{lid}_{side}"], 1] for lid in ("upper", "lower"))
        assert upper == pytest.approx(lower)


def test_a_new_neutral_pose_does_not_move_the_photo() -> None:
    warp = PortraitWarp(face_shape())
    warp.set_neutral(warp.shape.neutral + 0.1, warp.shape.fapu_lengths)
    np.testing.assert_allclose(warp.deform(warp.photo_displacements(), POSE), warp.mesh.positions, atol=2e-5)


def test_rotation_moves_the_nose_relative_to_the_brow() -> None:
    rotated = HeadPose(POSE.rotation + np.array((0, 0.25, 0)), POSE.position, POSE.log_scale)
    moved = WARP.deform(STILL, rotated) - WARP.mesh.positions
    nose, brow = CONTROL_POINT_INDEX["nose_bottom_edge_l"], CONTROL_POINT_INDEX["brow_outer_l"]
    assert moved[nose, 0] > moved[brow, 0] + 0.005


@pytest.mark.parametrize("direction", [(1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (-1, 1)])
def test_nothing_smears_when_the_head_moves_by_half_its_width(direction: tuple[int, int]) -> None:
    oval = WARP.mesh.positions[contours.OVAL_ROWS]
    shift = 0.5 * float(np.ptp(oval[:, 0])) * np.array(direction) / np.linalg.norm(direction)
    moved = WARP.deform(WARP.photo_displacements(), HeadPose(POSE.rotation, POSE.position + shift, POSE.log_scale))
    corners = [positions[WARP.mesh.triangles] for positions in (WARP.mesh.positions, moved)]
    before, after = (np.stack([c[:, 1] - c[:, 0], c[:, 2] - c[:, 0]], axis=2) for c in corners)
    stretch = np.linalg.svd(after @ np.linalg.inv(before), compute_uv=False)
    assert stretch.max() < MAX_STRETCH and stretch.min() > MIN_STRETCH
    np.testing.assert_allclose(moved[contours.OVAL_ROWS], oval + shift, atol=2e-3)


def test_the_torso_stays_while_the_neck_bends_and_follows_beyond() -> None:
    bottom = np.argmin(WARP.mesh.positions[:, 1])
    for centimetres, follows in ((1.0, False), (10.0, True)):
        pose = HeadPose(POSE.rotation, POSE.position + np.array([centimetres * WARP.scale, 0]), POSE.log_scale)
        shift = (WARP.deform_to(WARP.shape.points[:CONTROL_POINT_COUNT], pose) - WARP.mesh.positions)[bottom, 0]
        assert shift == pytest.approx(
            (centimetres - NECK_REACH_CM[0]) * WARP.scale if follows else 0, abs=0.25 * WARP.scale
        )


def test_the_torso_grows_with_a_head_that_comes_much_nearer() -> None:
    bottom = np.argsort(WARP.mesh.positions[:, 1])[:8]
    for growth, factor in ((0.05, 1.0), (0.5, np.exp(0.5 - NECK_GROWTH))):
        pose = HeadPose(POSE.rotation, POSE.position, POSE.log_scale + growth)
        moved = WARP.deform_to(WARP.shape.points[:CONTROL_POINT_COUNT], pose)
        widths = np.ptp(moved[bottom, 0]), np.ptp(WARP.mesh.positions[bottom, 0])
        assert widths[0] / widths[1] == pytest.approx(factor, rel=0.06)


@pytest.mark.slow
@given(st.lists(st.floats(-1.5, 1.5), min_size=3, max_size=3))
def test_the_rotation_out_of_the_image_plane_is_limited(rotation: list[float]) -> None:
    limited = limit_rotation(HeadPose(np.array(rotation), POSE.position, POSE.log_scale), POSE)
    since = limited.matrix() @ POSE.matrix().T
    assert np.arccos(np.clip(since[2, 2], -1, 1)) <= MAX_ROTATION + 1e-6


@pytest.mark.slow
@given(st.lists(st.floats(-0.15, 0.15), min_size=3, max_size=3))
def test_a_small_rotation_is_unchanged(rotation: list[float]) -> None:
    pose = HeadPose(POSE.rotation + rotation, POSE.position, POSE.log_scale)
    np.testing.assert_allclose(limit_rotation(pose, POSE).matrix(), pose.matrix(), atol=1e-9)


@pytest.mark.slow
@given(st.integers(0, 2**32 - 1), st.floats(0, 1500))
def test_no_motion_folds_a_triangle(seed: int, reach: float) -> None:
    rng = np.random.default_rng(seed)
    displacements = rng.uniform(-reach, reach, (CONTROL_POINT_COUNT, 3))
    pose = HeadPose(rng.uniform(-1, 1, 3), rng.uniform(-0.4, 0.4, 2), POSE.log_scale + rng.uniform(-0.5, 0.5))
    assert signed_areas(WARP.deform(displacements, pose), WARP.mesh.triangles).min() > 0


def test_weights_sum_to_1_and_each_lip_follows_its_own_points() -> None:
    regions = split_photo_regions(face_points()[:, :2])
    weights = np.array([field.weights for field in regions.fields])
    np.testing.assert_allclose(weights.sum(axis=0), 1)
    upper = contours.landmark_rows(contours.UPPER_INNER_LIP[1:-1])
    has_lower = [not set(LOWER_LIP) <= set(field.excluded) for field in regions.fields]
    assert weights[np.ix_(has_lower, upper)].max() == 0
    lower = contours.landmark_rows(contours.LOWER_INNER_LIP[1:-1])
    has_upper = [not set(UPPER_LIP) <= set(field.excluded) for field in regions.fields]
    assert weights[np.ix_(has_upper, lower)].max() == 0
    assert any(set(LOWER_LID) <= set(field.excluded) for field in regions.fields)
