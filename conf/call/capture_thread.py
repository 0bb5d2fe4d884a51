"""Capture in a thread of its own, so that neither reading a camera nor tracking a face delays drawing.

Strategy. A camera blocks until its next frame, up to 40 ms, and tracking takes as long as half a frame's drawing. The
thread owns the capture and everything that this was made of: camera, tracker, extractor, portrait scheduler. The loop
never calls them. It writes two wishes, the mode and the rate, and removes what was captured, which nobody changes any
more, from a queue. Objects of the portrait cross through a `SharedObjectSender`.
"""

import time
from collections import deque
from collections.abc import Callable
from types import TracebackType
from typing import Self

from conf.errors import ConfError
from conf.sender.face_capture import CapturedMotion, CaptureMode, FaceCapture
from conf.stoppable_thread import StoppableThread

MAX_WAITING = 8  # frames captured that the loop has not sent: half a second


class CaptureThread:
    """Runs a capture while the `with` block lasts.

    ended : whether the source has ended
    """

    def __init__(self, capture: FaceCapture, *, clock: Callable[[], float] = time.monotonic) -> None:
        self.ended = False
        self._capture = capture
        self._clock = clock
        self._captured: deque[CapturedMotion] = deque(maxlen=MAX_WAITING)
        self._fault = ""
        self._thread = StoppableThread(self._run, name="capture")

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._thread.stop()

    @property
    def capture(self) -> FaceCapture:
        """The capture: only for its figures, and only after the `with` block."""
        return self._capture

    @property
    def note(self) -> str:
        """What to tell the user while the camera fails, "" otherwise."""
        return self._capture.note

    @property
    def has_face(self) -> bool:
        """Whether the newest frame showed a face."""
        return self._capture.has_face

    @property
    def is_working(self) -> bool:
        """Whether a frame has come since the start, or since the last fault."""
        return self._capture.is_working

    def set_mode(self, mode: CaptureMode) -> None:
        """Switch the camera to a mode, from the next frame on."""
        self._capture.mode = mode

    def set_fps(self, fps: float) -> None:
        """Capture so many frames a second from now on."""
        self._capture.set_fps(fps)

    def set_portrait(self, *, is_allowed: bool) -> None:
        """Make images of the person, or none, from the next frame on."""
        self._capture.set_portrait(is_allowed=is_allowed)

    def source_time(self, now: float) -> float | None:
        """Return the time on the source's clock at `now`, None before the first frame."""
        return self._capture.source_time(now)

    def drain(self) -> list[CapturedMotion]:
        """Return what was captured since the last call, oldest first."""
        captured = []
        while self._captured:
            captured.append(self._captured.popleft())
        return captured

    def pop_fault(self) -> str:
        """Return why the camera was switched off since the last call, "" if it was not."""
        fault, self._fault = self._fault, ""
        return fault

    def _run(self) -> None:
        while not self._thread.is_stopped:
            try:
                wait = self._capture.step(self._clock())
            except ConfError as error:  # the call goes on without a face
                self._capture.restart()
                self._capture.mode, self._fault = CaptureMode.OFF, str(error)
                continue
            if (captured := self._capture.pop()) is not None:
                self._captured.append(captured)
            if wait is None:
                self.ended = True
                return
            if wait:
                self._thread.wait(wait)
