"""Ctrl-C: the first ends a call in order, the second at once."""

import signal

import pytest

from conf.commands.interruption import until_interrupted


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_the_first_signal_ends_the_loop_and_the_second_raises(number: signal.Signals) -> None:
    before = signal.getsignal(number)
    with until_interrupted() as should_continue:
        assert should_continue()
        signal.raise_signal(number)
        assert not should_continue()
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(number)
    assert signal.getsignal(number) == before
