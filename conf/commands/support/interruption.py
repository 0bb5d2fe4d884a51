"""Ctrl-C: a KeyboardInterrupt that nothing can swallow, and the normal end of a call."""

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

IMPORT_SYSTEM = "<frozen importlib._bootstrap>"
RETRY_S = 0.05


class InterruptHandler:
    """Signal handler that raises KeyboardInterrupt and remembers it: a library's callback may swallow it.

    While a module is imported it waits: libraries in C++ end the process when an exception is raised inside.
    """

    def __init__(self) -> None:
        self.was_called = False

    def __call__(self, number: int, frame: FrameType | None) -> None:
        self.was_called = True
        if not _is_importing(frame):
            raise KeyboardInterrupt
        again = threading.Timer(RETRY_S, signal.raise_signal, (number,))
        again.daemon = True
        again.start()


def _is_importing(frame: FrameType | None) -> bool:
    while frame is not None:
        if frame.f_code.co_filename == IMPORT_SYSTEM:
            return True
        frame = frame.f_back
    return False


def check_interrupt() -> None:
    """Raise KeyboardInterrupt if one was raised before and swallowed."""
    handler = signal.getsignal(signal.SIGINT)
    if isinstance(handler, InterruptHandler) and handler.was_called:
        raise KeyboardInterrupt


@contextmanager
def until_interrupted() -> Iterator[Callable[[], bool]]:
    """Yield a function that returns True until the first Ctrl-C or SIGTERM; the second one raises KeyboardInterrupt.

    A call so ended still closes its session, completes its recordings and prints its figures. An interrupt from before,
    while the call was prepared, raises KeyboardInterrupt.
    """
    check_interrupt()
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
