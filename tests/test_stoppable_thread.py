import threading

import pytest

from conf.stoppable_thread import MAX_SLEEP_S, StoppableThread

LONG_S = 1e6


@pytest.mark.parametrize("wait_s", [0.0, MAX_SLEEP_S / 10, LONG_S])
def test_a_thread_runs_until_it_is_stopped(wait_s: float) -> None:
    names: list[str] = []
    is_running = threading.Event()

    def run() -> None:
        names.append(threading.current_thread().name)
        is_running.set()
        while not thread.wait(wait_s):
            pass
        names.append("ended")

    thread = StoppableThread(run, name="a name")
    thread.start()
    assert is_running.wait(10.0) and not thread.is_stopped
    thread.stop()
    assert names == ["a name", "ended"] and thread.is_stopped


def test_a_thread_that_is_over_can_be_stopped_and_waits_no_more() -> None:
    ran: list[int] = []
    thread = StoppableThread(lambda: ran.append(1), name="short")
    thread.start()
    thread.stop()
    assert ran == [1] and thread.wait(LONG_S) and thread.wait(0.01)


def test_a_thread_that_was_never_started_or_hangs_can_be_stopped() -> None:
    StoppableThread(lambda: None, name="idle").stop()
    release = threading.Event()
    thread = StoppableThread(lambda: _wait(release), name="hangs")
    thread.start()
    thread.stop(0.01)
    assert thread.is_stopped
    release.set()
    thread.stop()


def _wait(event: threading.Event) -> None:
    assert event.wait(10.0)
