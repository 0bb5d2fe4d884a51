"""The window against a set of all counters ever received."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.protocol.session.drop_reasons import DatagramError, DropReason
from conf.protocol.session.replay_window import WINDOW, ReplayWindow


@pytest.mark.slow
@given(st.lists(st.integers(0, 300)))
def test_every_counter_is_accepted_once_and_only_inside_the_window(counters: list[int]) -> None:
    window, received = ReplayWindow(), set[int]()
    for counter in counters:
        highest = max(received, default=-1)
        allowed = counter not in received and counter > highest - WINDOW
        try:
            window.check(counter)
        except DatagramError:
            assert not allowed
            continue
        assert allowed
        window.accept(counter)
        received.add(counter)
    assert window.highest == max(received, default=-1)


def test_check_alone_changes_nothing() -> None:
    window = ReplayWindow()
    window.accept(3)
    window.check(1000)
    assert (window.highest, window.received) == (3, 1)


@pytest.mark.parametrize(("counter", "reason"), [(100, DropReason.REPLAYED), (36, DropReason.TOO_OLD)])
def test_the_reasons_for_rejection(counter: int, reason: DropReason) -> None:
    window = ReplayWindow()
    window.accept(100)
    with pytest.raises(DatagramError) as caught:
        window.check(counter)
    assert caught.value.reason is reason
