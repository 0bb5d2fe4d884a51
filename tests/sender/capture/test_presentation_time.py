import itertools
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.sender.capture.presentation_time import PlausibleTime, TimestampChoice

FPS = 25.0


def times(stated: list[float]) -> list[float]:
    clock = PlausibleTime(stated[0])
    return [clock.of(at, FPS) for at in stated]


def test_presentation_times_are_used_while_they_rise() -> None:
    choice = TimestampChoice()
    assert [choice.choose(pts, dts) for pts, dts in ((3, 0), (5, 1), (9, 2))] == [3, 5, 9]


def test_decoding_times_are_used_once_the_others_have_fallen_more_often() -> None:
    choice = TimestampChoice()
    # What FFmpeg guesses for H.264 with B-frames in AVI.
    pairs = [(1, 2), (4, 3), (3, 4), (5, 5), (2, 6), (7, 7)]
    assert [choice.choose(pts, dts) for pts, dts in pairs] == [1, 4, 4, 5, 6, 7]
    choice = TimestampChoice(has_presentation_times=False)
    assert [choice.choose(pts, dts) for pts, dts in pairs] == [2, 3, 4, 5, 6, 7]
    assert choice.choose(8, None) is None  # better none than a guess


def test_a_time_that_is_missing_is_replaced_by_the_other() -> None:
    choice = TimestampChoice()
    assert [choice.choose(*pair) for pair in ((None, 4), (5, None), (None, None), (6, 9))] == [4, 5, None, 6]


def test_joined_files_whose_times_begin_anew_keep_the_presentation_times() -> None:
    choice = TimestampChoice()
    assert [choice.choose(pts, dts) for pts, dts in ((0, 0), (1, 1), (2, 2), (0, 0), (1, 1))] == [0, 1, 2, 0, 1]


def test_times_start_at_zero_and_keep_their_steps() -> None:
    assert times([-3.0, -2.96, -2.5]) == pytest.approx([0.0, 0.04, 0.5])
    assert times([95443.7, 95443.74, 95448.7]) == pytest.approx([0.0, 0.04, 5.0])


def test_a_time_that_falls_costs_nothing_afterwards() -> None:
    assert times([0.0, 0.04, 0.03, 0.12, 0.16]) == pytest.approx([0.0, 0.04, 0.08, 0.12, 0.16])
    assert times([0.0, 0.04, 0.04, 0.04, 0.2]) == pytest.approx([0.0, 0.04, 0.08, 0.12, 0.2])


def test_joined_files_go_on_and_long_pauses_are_faults() -> None:
    assert times([0.0, 0.5, 1.0, 0.0, 0.5, 1.5]) == pytest.approx([0.0, 0.5, 1.0, 1.04, 1.54, 2.54])
    assert times([0.0, 0.04, 90.0, 90.04]) == pytest.approx([0.0, 0.04, 0.08, 0.12])
    assert times([0.0, math.inf, math.nan, 0.12]) == pytest.approx([0.0, 0.04, 0.08, 0.12])


def test_a_round_starts_where_the_last_has_ended() -> None:
    clock = PlausibleTime(2.0)
    assert [clock.of(at, FPS) for at in (2.0, 2.04)] == pytest.approx([0.0, 0.04])
    clock.restart(2.0, 0.08)
    assert clock.offset == pytest.approx(-1.92)
    assert [clock.of(at, FPS) for at in (2.0, 2.04)] == pytest.approx([0.08, 0.12])


@pytest.mark.slow
@given(st.lists(st.floats(-1e12, 1e12) | st.sampled_from([math.nan, math.inf, -math.inf]), min_size=1, max_size=50))
def test_times_always_rise(stated: list[float]) -> None:
    first = stated[0] if math.isfinite(stated[0]) else 0.0
    clock = PlausibleTime(first)
    result = [clock.of(at, FPS) for at in stated]
    assert result[0] == 0.0 and all(a < b <= a + 5.0 for a, b in itertools.pairwise(result))
