import threading
import time
from collections.abc import Callable

from conf.call.capture_thread import MAX_WAITING, CaptureThread
from conf.errors import CameraError
from conf.sender.face_capture import CapturedMotion, CaptureMode

LIMIT_S = 10.0  # of real time, for a machine that is very busy


class FakeCapture:
    """A capture whose steps a test lets happen. steps : thread of each step; error : raised by the next one"""

    def __init__(self, count: int) -> None:
        self.mode = CaptureMode.ON
        self.note = ""
        self.count = count
        self.steps: list[str] = []
        self.error: CameraError | None = None
        self.restarts = 0
        self.is_working = True
        self.allowed = True
        self._captured: CapturedMotion | None = None

    def step(self, now: float) -> float | None:
        self.steps.append(threading.current_thread().name)
        if (error := self.error) is not None:
            self.error = None
            raise error
        if self.mode is CaptureMode.OFF:
            return 0.001
        if self.count == 0:
            return None
        self.count -= 1
        self._captured = CapturedMotion(float(self.count), None, (1.0,) * 5)
        return 0.0

    def pop(self) -> CapturedMotion | None:
        captured, self._captured = self._captured, None
        return captured

    def restart(self) -> None:
        self.restarts += 1
        self.is_working = False


def wait_until(condition: Callable[[], bool]) -> None:
    """Wait for another thread."""
    deadline = time.monotonic() + LIMIT_S
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.001)


def test_frames_are_captured_in_a_thread_of_their_own_in_order() -> None:
    capture = FakeCapture(3)
    with CaptureThread(capture) as thread:  # type: ignore[arg-type]
        wait_until(lambda: thread.ended)
    assert set(capture.steps) == {"capture"}
    assert [captured.timestamp for captured in thread.drain()] == [2.0, 1.0, 0.0] and thread.drain() == []


def test_of_frames_that_nobody_sends_only_the_newest_are_kept() -> None:
    with CaptureThread(FakeCapture(100)) as thread:  # type: ignore[arg-type]
        wait_until(lambda: thread.ended)
    assert [captured.timestamp for captured in thread.drain()] == [float(n) for n in reversed(range(MAX_WAITING))]


def test_a_camera_that_fails_is_switched_off_and_said_once() -> None:
    capture = FakeCapture(10)
    capture.error = CameraError("camera 0 gives no images any more")
    with CaptureThread(capture) as thread:  # type: ignore[arg-type]
        wait_until(lambda: capture.restarts == 1)
        assert thread.pop_fault() == "camera 0 gives no images any more" and thread.pop_fault() == ""
        assert capture.mode is CaptureMode.OFF and not thread.ended
        assert not thread.is_working
        thread.set_mode(CaptureMode.ON)
        wait_until(lambda: thread.ended)
    assert capture.count == 0


def test_an_end_of_the_block_ends_the_thread() -> None:
    capture = FakeCapture(0)
    capture.mode = CaptureMode.OFF
    with CaptureThread(capture) as thread:  # type: ignore[arg-type]
        wait_until(lambda: len(capture.steps) > 2)
    count = len(capture.steps)
    time.sleep(0.01)
    assert len(capture.steps) == count and not thread.ended and thread.capture is capture
