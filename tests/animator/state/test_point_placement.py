import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.animator.state.point_placement import PointPlacement, left_points, mirror_point, swapped_pairs
from conf.face.control_points import CONTROL_POINT_COUNT, CONTROL_POINT_INDEX
from conf.face.symmetry import MIRROR_INDICES

PLACE = np.array([1.0, 2.0, 3.0])
orders = st.permutations(range(CONTROL_POINT_COUNT))


@given(orders)
def test_advancing_visits_every_point_once_whatever_was_placed_before(order: list[int]) -> None:
    placing = PointPlacement()
    for point in order[:20]:
        placing = placing.set_point(point, PLACE)
    placing = placing.select(order[0]).advance()
    visited = []
    while placing.missing:
        visited.append(placing.selected)
        placing = placing.set_point(placing.selected, PLACE).advance()
    assert sorted(visited) == sorted(order[20:])
    assert placing.advance() == placing


def test_a_partner_is_placed_along_unless_the_point_is_its_own() -> None:
    left, right = CONTROL_POINT_INDEX["brow_inner_l"], CONTROL_POINT_INDEX["brow_inner_r"]
    placing = PointPlacement().set_point(left, PLACE, mirror_point(PLACE, 0.0))
    np.testing.assert_array_equal(placing.points[right], [-1.0, 2.0, 3.0])
    chin = CONTROL_POINT_INDEX["chin_bottom"]
    placing = placing.set_point(chin, PLACE, mirror_point(PLACE, 0.0))
    np.testing.assert_array_equal(placing.points[chin], PLACE)
    assert placing.missing == CONTROL_POINT_COUNT - 3
    assert left_points(placing) == [left]


def test_undo_goes_back_step_by_step_and_no_further() -> None:
    first = PointPlacement().push_undo().set_point(0, PLACE)
    second = first.push_undo().set_point(1, PLACE)
    np.testing.assert_array_equal(second.undo().points, first.points)
    assert second.undo().undo().missing == CONTROL_POINT_COUNT
    assert second.undo().undo().undo().missing == CONTROL_POINT_COUNT


def test_the_middle_is_that_of_the_middle_points() -> None:
    assert PointPlacement().middle(7.0) == 7.0
    placing = (
        PointPlacement()
        .set_point(CONTROL_POINT_INDEX["chin_bottom"], PLACE)
        .set_point(CONTROL_POINT_INDEX["brow_inner_l"], 9 * PLACE)
    )
    assert placing.middle(7.0) == pytest.approx(1.0)


def test_sides_that_were_taken_for_each_other_are_named() -> None:
    left = CONTROL_POINT_INDEX["pupil_l"]
    right = MIRROR_INDICES[left]
    assert swapped_pairs(PointPlacement().set_point(left, PLACE).set_point(right, -PLACE)) == []
    assert swapped_pairs(PointPlacement().set_point(left, -PLACE).set_point(right, PLACE)) == [(left, right)]
