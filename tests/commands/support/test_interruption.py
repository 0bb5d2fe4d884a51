"""Ctrl-C: the first ends a call in order, the second at once."""

import contextlib
import signal
from collections.abc import Iterator
from unittest.mock import Mock

import pytest

from conf.commands.support.interruption import (
    IMPORT_SYSTEM,
    RETRY_S,
    InterruptHandler,
    check_interrupt,
    until_interrupted,
)


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


@pytest.fixture
def handler() -> Iterator[InterruptHandler]:
    """A handler of SIGINT."""
    handler, before = InterruptHandler(), signal.getsignal(signal.SIGINT)
    signal.signal(signal.SIGINT, handler)
    yield handler
    signal.signal(signal.SIGINT, before)


def test_an_interrupt_that_was_swallowed_is_raised_again(handler: InterruptHandler) -> None:
    check_interrupt()
    with contextlib.suppress(KeyboardInterrupt):
        signal.raise_signal(signal.SIGINT)
    assert handler.was_called
    with pytest.raises(KeyboardInterrupt):
        check_interrupt()
    with pytest.raises(KeyboardInterrupt), until_interrupted():
        pytest.fail("the call has begun")


def test_an_interrupt_during_an_import_waits_for_its_end(
    handler: InterruptHandler, monkeypatch: pytest.MonkeyPatch
) -> None:
    timer = Mock()
    monkeypatch.setattr("conf.commands.support.interruption.threading.Timer", timer)
    exec(compile("import signal; signal.raise_signal(signal.SIGINT)", IMPORT_SYSTEM, "exec"))
    assert handler.was_called
    delay, repeat, arguments = timer.call_args.args
    assert delay == RETRY_S
    with pytest.raises(KeyboardInterrupt):
        repeat(*arguments)
