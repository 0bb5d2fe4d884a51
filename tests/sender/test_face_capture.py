from dataclasses import dataclass, field

import numpy as np
import pytest

from conf.errors import CameraError
from conf.protocol.messages import MotionFrame, StreamParameters
from conf.protocol.motion.outbound import OutboundMotion
from conf.protocol.stream_clocks import StreamClock
from conf.sender.face_capture import CapturedMotion, CaptureMode, FaceCapture, send_motion

FPS = 30.0
FAPU = (6.4, 4.5, 3.0, 5.0, 1.1)


@dataclass
class FakeSource:
    """A camera or clip of 30 frames a second. log : what was asked of it"""

    frames: int = 1000
    is_live: bool = True
    calibrated: bool = True
    tracker_ms: float = 4.0
    fapu_lengths: tuple[float, ...] = FAPU
    failing: bool = False
    faces: bool = True
    number: int = -1
    log: list[str] = field(default_factory=list)

    def next_frame(self) -> float | None:
        if self.failing:
            raise CameraError("camera 0 gives no images any more")
        self.number += 1
        self.log.append("read")
        return None if self.number >= self.frames else self.number / FPS

    def motion(self) -> MotionFrame | None:
        self.log.append("track")
        pose = np.array([0.0, 0.0, 0.0, 0.0, 0.0, -3.5])
        return MotionFrame(self.number / FPS, np.zeros((50, 3), np.float32), pose) if self.faces else None

    def show(self) -> None:
        self.log.append("show")

    def release(self) -> None:
        self.log.append("release")

    def after_send(self, now: float) -> None:
        self.log.append("after send")


class Runner:
    """Steps a capture through simulated time. captured : (time, what was captured)"""

    def __init__(self, source: FakeSource, *, fps: float = FPS, mode: CaptureMode = CaptureMode.ON) -> None:
        self.source, self.now = source, 100.0
        self.capture = FaceCapture(source, fps, mode=mode)  # type: ignore[arg-type]
        self.captured: list[tuple[float, CapturedMotion]] = []
        self.ended = False

    def run(self, seconds: float) -> list[str]:
        """Let time pass. Returns what was asked of the source meanwhile."""
        self.source.log.clear()
        end = self.now + seconds
        while self.now < end and not self.ended:
            wait = self.capture.step(self.now)
            if (captured := self.capture.pop()) is not None:
                self.captured.append((self.now, captured))
            self.ended = wait is None
            self.now += max(wait or 0.0, 1e-4)
        return list(self.source.log)


def test_each_frame_is_captured_at_its_time_until_the_source_ends() -> None:
    runner = Runner(FakeSource(frames=31))
    runner.run(5.0)
    assert runner.ended and runner.capture.frames == runner.capture.tracked == 31
    times = [at for at, _ in runner.captured]
    np.testing.assert_allclose(np.diff(times), 1 / FPS, atol=0.002)
    assert runner.captured[-1][1].timestamp == pytest.approx(1.0)
    assert runner.captured[-1][1].fapu_lengths == FAPU and runner.capture.has_face


def test_frames_beyond_the_rate_are_not_tracked() -> None:
    runner = Runner(FakeSource())
    runner.capture.set_fps(10.0)
    log = runner.run(2.0)
    assert log.count("track") == pytest.approx(20, abs=1) and log.count("read") == pytest.approx(60, abs=2)


def test_what_was_captured_is_returned_once_and_before_the_portrait_is_worked_on() -> None:
    source = FakeSource()
    capture, now = FaceCapture(source, FPS), 0.0  # type: ignore[arg-type]
    while (captured := capture.pop()) is None:
        now += capture.step(now) or 0.0
    assert source.log[-1] == "track" and captured.motion is not None and capture.pop() is None
    capture.step(now)
    assert source.log[-1] == "after send" or "after send" in source.log


def test_a_frame_without_a_face_is_captured_without_motion() -> None:
    runner = Runner(FakeSource(faces=False))
    runner.run(1.0)
    assert runner.captured[-1][1].motion is None and not runner.capture.has_face
    assert runner.capture.frames > 20 and runner.capture.tracked == 0


def test_a_camera_in_preview_is_shown_and_not_tracked() -> None:
    runner = Runner(FakeSource(), mode=CaptureMode.PREVIEW)
    log = runner.run(1.0)
    assert log.count("show") == pytest.approx(30, abs=2) and "track" not in log and not runner.captured


def test_a_camera_that_is_switched_off_is_released_and_comes_back() -> None:
    runner = Runner(FakeSource())
    runner.run(1.0)
    runner.capture.mode = CaptureMode.OFF
    runner.run(0.2)
    assert set(runner.run(1.0)) == {"release"} and not runner.capture.has_face
    count = len(runner.captured)
    runner.capture.mode = CaptureMode.ON
    runner.run(2.0)
    assert len(runner.captured) > count + 20


def test_a_clip_does_not_begin_before_it_is_on_and_runs_on_while_it_is_off() -> None:
    runner = Runner(FakeSource(is_live=False), mode=CaptureMode.PREVIEW)
    assert runner.run(1.0) == []
    runner.capture.mode = CaptureMode.ON
    runner.run(1.0)
    runner.capture.mode = CaptureMode.OFF
    runner.run(0.1)
    assert set(runner.run(1.0)) == {"read"}
    runner.capture.mode = CaptureMode.ON
    runner.run(1.0)
    assert runner.captured[-1][1].timestamp == pytest.approx(runner.now - 101.0, abs=0.1)


def test_a_camera_that_fails_is_tried_for_five_seconds() -> None:
    runner = Runner(FakeSource())
    runner.run(1.0)
    runner.source.failing = True
    runner.run(2.0)
    assert runner.capture.note.startswith("camera 0 gives no images any more (trying for")
    runner.source.failing = False
    runner.run(1.0)
    assert runner.capture.note == ""
    runner.source.failing = True
    with pytest.raises(CameraError):
        runner.run(6.0)


def test_the_time_of_the_source_runs_from_its_first_frame() -> None:
    runner = Runner(FakeSource(is_live=False))
    assert runner.capture.source_time(100.0) is None
    runner.run(0.5)
    assert runner.capture.source_time(103.0) == pytest.approx(3.0, abs=0.01)


def test_before_a_camera_has_an_image_its_time_is_the_machine_s() -> None:
    runner = Runner(FakeSource())
    assert runner.capture.source_time(100.0) == 100.0 and not runner.capture.is_working
    runner.run(0.5)
    assert runner.capture.is_working
    runner.capture.restart()
    assert not runner.capture.is_working


class Outlet:
    """Records what is sent."""

    def __init__(self) -> None:
        self.outbound = OutboundMotion(StreamParameters(320, 240, 15.0, 50, (1.0,) * 5), clock=StreamClock())
        self.frames: list[MotionFrame] = []
        self.absences: list[float] = []

    def send_frame(self, frame: MotionFrame, now: float) -> None:
        self.frames.append(frame)

    def send_no_face(self, timestamp: float, now: float) -> None:
        self.absences.append(timestamp)


def test_motion_is_sent_with_the_measures_of_its_face() -> None:
    outlet = Outlet()
    frame = MotionFrame(1.0, np.zeros((50, 3), np.float32), np.zeros(6))
    send_motion(outlet, CapturedMotion(1.0, frame, FAPU), 5.0)
    send_motion(outlet, CapturedMotion(2.0, None, FAPU), 6.0)
    assert outlet.frames == [frame] and outlet.absences == [2.0] and outlet.outbound.parameters.fapu == FAPU
