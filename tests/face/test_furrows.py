"""Furrows knit and lower brows that the landmarks have not moved, and never raise or part them."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_COUNT, CONTROL_POINT_INDEX, control_point_indices
from conf.face.furrows import (
    FOREHEAD_BEGIN,
    FOREHEAD_DEPTH,
    FOREHEAD_END,
    KNIT,
    LOWERING,
    RAISED,
    SMOOTH_SKIN,
    knit_brows,
    skin_furrows,
)

LEFT, RIGHT = CONTROL_POINT_INDEX["brow_inner_l"], CONTROL_POINT_INDEX["brow_inner_r"]
BROWS = control_point_indices("brow")


def face(*, knit: float = 0.0, raised: float = 0.0) -> NDArray[np.float32]:
    """Return displacements whose inner brows are knit, each by so many units, and whose brows are raised."""
    displacements = np.zeros((CONTROL_POINT_COUNT, 3), np.float32)
    displacements[LEFT, 0], displacements[RIGHT, 0] = -knit, knit
    displacements[BROWS, 1] = raised
    return displacements


def test_no_furrows_change_nothing() -> None:
    displacements = face(knit=3.0)
    assert knit_brows(displacements, 0.0) is displacements


def test_full_furrows_knit_and_lower_resting_brows() -> None:
    moved = knit_brows(face(), 1.0)
    assert moved[LEFT, :2] == pytest.approx([-KNIT, -LOWERING], rel=1e-6)
    assert moved[RIGHT, :2] == pytest.approx([KNIT, -LOWERING], rel=1e-6)
    others = np.delete(np.arange(CONTROL_POINT_COUNT), BROWS)
    assert not moved[others].any() and not moved[:, 2].any()


def test_brows_that_landmarks_have_moved_as_far_are_not_moved_again() -> None:
    displacements = face(knit=KNIT, raised=-LOWERING)
    np.testing.assert_allclose(knit_brows(displacements, 1.0), displacements, atol=1e-4)
    np.testing.assert_allclose(knit_brows(2 * displacements, 1.0), 2 * displacements, atol=1e-4)


def test_raised_brows_are_knit_and_stay_raised() -> None:
    moved = knit_brows(face(raised=RAISED), 1.0)
    assert moved[LEFT, 0] == pytest.approx(-KNIT) and moved[LEFT, 1] == pytest.approx(RAISED)


@given(st.floats(-60, 60), st.floats(-60, 60), st.floats(0, 1))
def test_furrows_only_knit_and_lower_by_bounded_distances(knit: float, raised: float, furrow: float) -> None:
    before = face(knit=knit, raised=raised)
    change = knit_brows(before, furrow) - before
    assert -KNIT - 1e-3 <= change[LEFT, 0] <= 1e-3 and change[RIGHT, 0] == pytest.approx(-change[LEFT, 0], abs=1e-3)
    assert -LOWERING - 1e-3 <= change[LEFT, 1] <= 1e-3
    assert abs(change).max() <= max(KNIT, LOWERING) + 1e-3


def test_skin_is_folded_between_the_brows_by_furrows_and_across_by_raised_brows() -> None:
    assert skin_furrows(None, 1.0) == SMOOTH_SKIN == skin_furrows(face(), 0.0)
    assert (
        skin_furrows(face(), 0.4).between_brows == pytest.approx(0.4) and skin_furrows(face(), 2.0).between_brows == 1
    )
    assert skin_furrows(face(), 1.0).forehead == skin_furrows(face(raised=0.99 * FOREHEAD_BEGIN), 1.0).forehead == 0
    assert skin_furrows(face(raised=2 * FOREHEAD_END), 0.0).forehead == pytest.approx(FOREHEAD_DEPTH)
