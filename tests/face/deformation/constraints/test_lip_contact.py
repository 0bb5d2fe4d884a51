"""Shut lips stay shut: small distances between them are noise, larger ones are drawn in full."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.face.control_points import CONTROL_POINT_INDEX, LOWER_LIP, UPPER_LIP
from conf.face.default_head import default_points
from conf.face.deformation.constraints.lip_contact import CLOSED_CM, drawn_opening, keep_lips_shut, send_lips_shut

UPPER, LOWER = CONTROL_POINT_INDEX["inner_lip_upper_mid"], CONTROL_POINT_INDEX["inner_lip_lower_mid"]


def opened(distance: float) -> np.ndarray:
    """Return offsets of lips that are apart by a distance, cm, along their whole width."""
    offsets = np.zeros((50, 3), np.float32)
    offsets[UPPER_LIP, 1], offsets[LOWER_LIP, 1] = distance / 4, -distance * 3 / 4
    return offsets


@pytest.mark.parametrize(("distance", "drawn"), [(0.0, 0.0), (0.05, 0.0), (CLOSED_CM, 0.0), (0.26, 0.26), (1.5, 1.5)])
def test_small_openings_are_drawn_shut_and_large_ones_in_full(distance: float, drawn: float) -> None:
    kept = keep_lips_shut(default_points(), opened(distance))
    assert kept[UPPER, 1] - kept[LOWER, 1] == pytest.approx(drawn, abs=1e-6)


def test_lips_keep_their_thickness_and_other_points_their_place() -> None:
    offsets = opened(0.08)
    kept = keep_lips_shut(default_points(), offsets)
    for lip in (UPPER_LIP, LOWER_LIP):
        moved = (kept - offsets)[lip]
        assert moved == pytest.approx(np.tile(moved[0], (len(lip), 1)), abs=1e-6)
    others = np.setdiff1d(np.arange(50), UPPER_LIP + LOWER_LIP)
    np.testing.assert_array_equal(kept[others], offsets[others])


@given(st.floats(0, 0.5), st.floats(0, 0.1))
def test_a_wider_opening_is_drawn_wider_and_none_is_exaggerated(opening: float, more: float) -> None:
    small, large = drawn_opening(np.array([opening, opening + more]))
    assert small <= large + 1e-9
    assert 0 <= small <= opening


def test_pressed_lips_do_not_pass_through_each_other() -> None:
    assert drawn_opening(np.array([-0.2, -0.01])).tolist() == pytest.approx([-0.03, -0.01])


def test_a_mouth_that_is_open_in_the_neutral_pose_is_left_alone() -> None:
    points = default_points().copy()
    points[UPPER, 1] = points[LOWER, 1] + 0.5
    np.testing.assert_array_equal(keep_lips_shut(points, opened(0.05)), opened(0.05))


@pytest.mark.parametrize(
    ("tracked", "sent"), [(-0.1, -0.1), (0.0, 0.0), (0.12, 0.0), (0.17, 0.085), (0.22, 0.22), (1.5, 1.5)]
)
def test_lips_that_are_tracked_slightly_apart_are_sent_shut(tracked: float, sent: float) -> None:
    offsets = opened(tracked).astype(np.float64)
    moved = send_lips_shut(offsets)
    assert moved[UPPER, 1] - moved[LOWER, 1] == pytest.approx(sent, abs=1e-6)
    for lip in (UPPER_LIP, LOWER_LIP):
        assert (moved - offsets)[lip] == pytest.approx(np.tile((moved - offsets)[lip[0]], (len(lip), 1)), abs=1e-6)
