"""Raising the priority of a thread: real time where it is allowed, else niceness, else nothing."""

import os
import sys
import threading

import pytest

from conf.thread_priority import NICENESS, raise_thread_priority

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="other systems leave it to the sound library")


def _refuse(*_: object) -> None:
    raise PermissionError("not allowed")


def test_asks_for_real_time_for_the_calling_thread_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[tuple[int, int, int]] = []
    monkeypatch.setattr(
        os, "sched_setscheduler", lambda who, policy, param: asked.append((who, policy, param.sched_priority))
    )
    raise_thread_priority()
    assert asked == [(0, os.SCHED_FIFO | os.SCHED_RESET_ON_FORK, 1)]


def test_asks_for_niceness_where_real_time_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[tuple[int, int, int]] = []
    monkeypatch.setattr(os, "sched_setscheduler", _refuse)
    monkeypatch.setattr(os, "setpriority", lambda *arguments: asked.append(arguments))
    raise_thread_priority()
    assert asked == [(os.PRIO_PROCESS, threading.get_native_id(), NICENESS)]


def test_goes_on_where_nothing_is_allowed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "sched_setscheduler", _refuse)
    monkeypatch.setattr(os, "setpriority", _refuse)
    raise_thread_priority()


def test_leaves_other_threads_as_they_are() -> None:
    before, within = os.sched_getscheduler(0), []

    def run() -> None:
        raise_thread_priority()
        within.append(os.sched_getscheduler(0) & ~os.SCHED_RESET_ON_FORK)

    thread = threading.Thread(target=run)
    thread.start()
    thread.join()
    assert within in ([os.SCHED_FIFO], [before])
    assert os.sched_getscheduler(0) == before
