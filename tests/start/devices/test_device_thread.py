"""Threads of devices: they end when they are told to, try again, and say what is wrong."""

import threading
from collections.abc import Callable

import pytest

from conf.errors import CameraError
from conf.start.devices import device_thread
from conf.start.devices.device_thread import DeviceThread

LIMIT_S = 20.0  # of a wait for something that happens at once


@pytest.fixture(autouse=True)
def _no_wait(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(device_thread, "RETRY_S", 0.0)


def failing_until(count: int, reached: threading.Event) -> Callable[[DeviceThread], None]:
    """Return a use that fails count - 1 times."""
    calls: list[str] = []

    def use(thread: DeviceThread) -> None:
        calls.append(thread.error)
        if len(calls) < count:
            raise CameraError(f"there is no camera, {len(calls)}")
        reached.set()
        thread.wait(LIMIT_S)

    return use


def test_a_device_that_fails_is_tried_again() -> None:
    reached = threading.Event()
    thread = DeviceThread(failing_until(3, reached), name="test")
    assert reached.wait(LIMIT_S)
    assert thread.error == "there is no camera, 2" and thread.is_running
    assert thread.close() and not thread.is_running


def test_without_retry_a_failure_is_the_end() -> None:
    thread = DeviceThread(failing_until(2, threading.Event()), name="test", retry=False)
    assert thread.close()
    assert thread.error == "there is no camera, 1"


def test_a_library_that_does_not_return_is_not_waited_for(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(device_thread, "CLOSE_S", 0.0)
    release = threading.Event()
    thread = DeviceThread(lambda _: assert_true(release.wait(LIMIT_S)), name="test")
    assert not thread.close()
    release.set()
    monkeypatch.setattr(device_thread, "CLOSE_S", LIMIT_S)
    assert thread.close()


def test_closing_can_begin_before_it_is_waited_for() -> None:
    thread = DeviceThread(lambda thread: assert_true(thread.wait(LIMIT_S)), name="test")
    thread.begin_close()
    assert thread.close() and thread.wait(LIMIT_S)


def assert_true(value: bool) -> None:
    assert value
