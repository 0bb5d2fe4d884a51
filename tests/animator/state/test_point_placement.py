import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.animator.state.point_placement import PointPlacement
from conf.face.control_points import CONTROL_POINT_COUNT, CONTROL_POINT_INDEX
from conf.face.symmetry import MIRROR_INDICES

POSITION = np.array([1.0, 2.0, 3.0])
CHIN = CONTROL_POINT_INDEX["chin_bottom"]
orders = st.permutations(range(CONTROL_POINT_COUNT))


@pytest.mark.slow
@given(orders)
def test_advancing_visits_every_missing_point_once(order: list[int]) -> None:
    placement = PointPlacement()
    for point in order[:20]:
        placement = placement.set_point(point, POSITION)
    placement = placement.select(order[0]).advance()
    visited = []
    while placement.missing:
        visited.append(placement.selected)
        placement = placement.set_point(placement.selected, POSITION).advance()
    assert sorted(visited) == sorted(order[20:])
    assert placement.advance() == placement


def test_the_partner_is_set_too_unless_the_point_is_its_own_partner() -> None:
    left, right = CONTROL_POINT_INDEX["brow_inner_l"], CONTROL_POINT_INDEX["brow_inner_r"]
    placement = PointPlacement().set_point(left, POSITION, -POSITION)
    np.testing.assert_array_equal(placement.points[right], -POSITION)
    placement = placement.set_point(CHIN, POSITION, -POSITION)
    np.testing.assert_array_equal(placement.points[CHIN], POSITION)
    assert placement.missing == CONTROL_POINT_COUNT - 3
    assert placement.left_points == [left]


def test_undo_returns_step_by_step_to_the_start() -> None:
    first = PointPlacement().push_undo().set_point(0, POSITION)
    second = first.push_undo().set_point(1, POSITION)
    np.testing.assert_array_equal(second.undo().points, first.points)
    assert second.undo().undo().missing == CONTROL_POINT_COUNT
    assert second.undo().undo().undo().missing == CONTROL_POINT_COUNT


def test_positions_are_mirrored_at_the_mean_of_the_middle_points() -> None:
    assert PointPlacement().mirrored(POSITION, 7.0) == pytest.approx([13.0, 2.0, 3.0])
    brow = CONTROL_POINT_INDEX["brow_inner_l"]
    placement = PointPlacement().set_point(CHIN, 3 * POSITION).set_point(brow, 9 * POSITION)
    assert placement.mirrored(POSITION, 7.0) == pytest.approx([5.0, 2.0, 3.0])


def test_swapped_sides_are_reported() -> None:
    left = CONTROL_POINT_INDEX["pupil_l"]
    right = MIRROR_INDICES[left]
    assert PointPlacement().set_point(left, POSITION).set_point(right, -POSITION).swapped_pairs == []
    assert PointPlacement().set_point(left, -POSITION).set_point(right, POSITION).swapped_pairs == [(left, right)]
