from hypothesis import given
from hypothesis import strategies as st

from conf.receiver.heads.assignment import HeadAssignment

NUMBERS = (1, 2, 3, 4, 5, 6)


def assigned(choices: dict[int, int]) -> dict[int, int]:
    assignment = HeadAssignment(NUMBERS)
    assignment.update(choices)
    return assignment.heads


def test_callers_without_a_choice_get_different_heads_as_far_as_there_are() -> None:
    heads = assigned(dict.fromkeys(range(9), 0))
    assert [heads[who] for who in range(6)] == [*NUMBERS]
    assert sorted(heads[who] for who in (6, 7, 8)) == [1, 2, 3]


def test_a_choice_holds_whoever_else_has_that_head_and_is_free_for_nobody_else() -> None:
    assert assigned({10: 0, 11: 1, 12: 1, 13: 0}) == {10: 2, 11: 1, 12: 1, 13: 3}


def test_an_unknown_number_is_the_default_head() -> None:
    assert assigned({5: 127}) == {5: 1}


def test_a_head_that_was_given_stays_when_others_come_and_go() -> None:
    assignment = HeadAssignment(NUMBERS)
    assignment.update({1: 0, 2: 0})
    assignment.update({2: 0, 3: 2})
    assert assignment.heads == {2: 2, 3: 2}
    assignment.update({2: 0, 3: 2, 4: 0})
    assert assignment.heads == {2: 2, 3: 2, 4: 1}


def test_a_choice_that_arrives_late_replaces_the_head_that_was_given() -> None:
    assignment = HeadAssignment(NUMBERS)
    assignment.update({1: 0, 2: 0})
    assignment.update({1: 4, 2: 0})
    assert assignment.heads == {1: 4, 2: 2}


@given(st.lists(st.dictionaries(st.integers(0, 12), st.integers(0, 127), max_size=9), max_size=6))
def test_everybody_has_a_head_and_only_who_is_there(history: list[dict[int, int]]) -> None:
    assignment = HeadAssignment(NUMBERS)
    for choices in history:
        assignment.update(choices)
        assert assignment.heads.keys() == choices.keys()
        assert set(assignment.heads.values()) <= set(NUMBERS)
