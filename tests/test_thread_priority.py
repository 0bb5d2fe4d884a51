"""Raising the priority of a thread: real time where it is allowed, else niceness, else nothing."""

import os
import sys
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import pytest

from conf.thread_priority import NICENESS, raise_thread_priority

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="other systems leave it to the sound library")


def in_a_thread(run: Callable[[], object]) -> None:
    """Run a function in a thread of its own; raise what it raises."""
    with ThreadPoolExecutor(1) as executor:
        executor.submit(run).result()


def refuse(*_: object) -> None:
    raise PermissionError("not allowed")


def test_asks_for_real_time_for_the_calling_thread_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[tuple[int, int, int]] = []
    monkeypatch.setattr(
        os, "sched_setscheduler", lambda who, policy, param: asked.append((who, policy, param.sched_priority))
    )
    in_a_thread(raise_thread_priority)
    assert asked == [(0, os.SCHED_FIFO | os.SCHED_RESET_ON_FORK, 1)]


def test_asks_for_niceness_where_real_time_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[tuple[int, int, int]] = []
    monkeypatch.setattr(os, "sched_setscheduler", refuse)
    monkeypatch.setattr(os, "setpriority", lambda *arguments: asked.append(arguments))
    in_a_thread(raise_thread_priority)
    ((kind, thread, niceness),) = asked
    assert (kind, niceness) == (os.PRIO_PROCESS, NICENESS) and thread != threading.main_thread().native_id


def test_goes_on_where_nothing_is_allowed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "sched_setscheduler", refuse)
    monkeypatch.setattr(os, "setpriority", refuse)
    in_a_thread(raise_thread_priority)


def test_the_main_thread_stays_as_it_is() -> None:
    before = os.sched_getscheduler(0)
    raise_thread_priority()
    in_a_thread(raise_thread_priority)
    assert os.sched_getscheduler(0) == before
