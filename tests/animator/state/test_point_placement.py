import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.animator.state.point_placement import Placing, exchanged, left_points, reflected
from conf.face.control_points import CONTROL_POINT_COUNT, INDEX
from conf.face.symmetry import PARTNERS

PLACE = np.array([1.0, 2.0, 3.0])
orders = st.permutations(range(CONTROL_POINT_COUNT))


@given(orders)
def test_advancing_visits_every_point_once_whatever_was_placed_before(order: list[int]) -> None:
    placing = Placing()
    for point in order[:20]:
        placing = placing.put(point, PLACE)
    placing = placing.select(order[0]).advance()
    visited = []
    while placing.missing:
        visited.append(placing.selected)
        placing = placing.put(placing.selected, PLACE).advance()
    assert sorted(visited) == sorted(order[20:])
    assert placing.advance() == placing


def test_a_partner_is_placed_along_unless_the_point_is_its_own() -> None:
    left, right = INDEX["brow_inner_l"], INDEX["brow_inner_r"]
    placing = Placing().put(left, PLACE, reflected(PLACE, 0.0))
    np.testing.assert_array_equal(placing.positions[right], [-1.0, 2.0, 3.0])
    chin = INDEX["chin_bottom"]
    placing = placing.put(chin, PLACE, reflected(PLACE, 0.0))
    np.testing.assert_array_equal(placing.positions[chin], PLACE)
    assert placing.missing == CONTROL_POINT_COUNT - 3
    assert left_points(placing) == [left]


def test_undo_goes_back_step_by_step_and_no_further() -> None:
    first = Placing().remember().put(0, PLACE)
    second = first.remember().put(1, PLACE)
    np.testing.assert_array_equal(second.undo().positions, first.positions)
    assert second.undo().undo().missing == CONTROL_POINT_COUNT
    assert second.undo().undo().undo().missing == CONTROL_POINT_COUNT


def test_the_middle_is_that_of_the_middle_points() -> None:
    assert Placing().middle(7.0) == 7.0
    placing = Placing().put(INDEX["chin_bottom"], PLACE).put(INDEX["brow_inner_l"], 9 * PLACE)
    assert placing.middle(7.0) == pytest.approx(1.0)


def test_sides_that_were_taken_for_each_other_are_named() -> None:
    left = INDEX["pupil_l"]
    right = PARTNERS[left]
    assert exchanged(Placing().put(left, PLACE).put(right, -PLACE)) == []
    assert exchanged(Placing().put(left, -PLACE).put(right, PLACE)) == [(left, right)]
