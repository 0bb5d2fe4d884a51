"""Ctrl-C as the normal end of a call."""

import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType


@contextmanager
def until_interrupted() -> Iterator[Callable[[], bool]]:
    """Yield a function that returns True until the first Ctrl-C or SIGTERM; the second one raises KeyboardInterrupt.

    A call so ended still closes its session, completes its recordings and prints its figures.
    """
    interrupted = False

    def on_signal(number: int, frame: FrameType | None) -> None:
        nonlocal interrupted
        if interrupted:
            signal.default_int_handler(number, frame)
        interrupted = True

    previous = {number: signal.signal(number, on_signal) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield lambda: not interrupted
    finally:
        for number, handler in previous.items():
            signal.signal(number, handler)
