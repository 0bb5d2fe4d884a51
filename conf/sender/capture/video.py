"""Where frames come from: a camera, or a clip that plays at its own speed. Timestamps only; the loop waits."""

import math
import os
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Protocol, Self

import cv2
import numpy as np
from numpy.typing import NDArray

from conf.errors import CameraError

DEFAULT_FPS = 25.0  # for files that do not say, as folders of pictures
MAX_FPS = 240.0
MAX_PAUSE_S = 5.0  # a longer step between two frames of a clip is a fault of the file
CAMERA_SIZE = (640, 480)
"""Larger pictures cost bandwidth on the camera's cable and time, and the tracker looks at 256 pixels of them."""

VideoCapture = cv2.VideoCapture
Opener = Callable[[str | int], VideoCapture]


def open_capture(what: str | int) -> VideoCapture:
    """Open a camera by index or device, or a file, with OpenCV."""
    return cv2.VideoCapture(what)


@dataclass(frozen=True)
class Frame:
    """A picture and when it was taken.

    pixels : (H, W, 3) uint8 BGR
    timestamp : seconds: of a camera on the machine's clock, of a clip from its start; never falls
    """

    pixels: NDArray[np.uint8]
    timestamp: float


class FrameSource(Protocol):
    """Something that gives frames."""

    @property
    def fps(self) -> float:
        """Frames a second, as far as the source knows."""

    @property
    def size(self) -> tuple[int, int]:
        """Width and height in pixels."""

    @property
    def frame_count(self) -> int | None:
        """How many frames there are, about, or None when that is not known."""

    def read(self) -> Frame | None:
        """Return the next frame, or None when there are no more. Raises CameraError when a camera has stopped."""

    def close(self) -> None:
        """Give the device or file back."""


class _CaptureSource:
    """What a camera and a clip share: a capture whose first frame has been read, to know that there is one."""

    def __init__(self, capture: VideoCapture, first: NDArray[np.uint8]) -> None:
        self._capture = capture
        self._first: NDArray[np.uint8] | None = first
        self.fps = _sane_fps(capture.get(cv2.CAP_PROP_FPS))
        self.frame_count = _sane_count(capture.get(cv2.CAP_PROP_FRAME_COUNT))
        self.size = (first.shape[1], first.shape[0])

    def close(self) -> None:
        """Give the device or file back."""
        self._capture.release()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _next(self) -> NDArray[np.uint8] | None:
        pixels, self._first = self._first, None
        return pixels if pixels is not None else _read(self._capture)


class Camera(_CaptureSource):
    """A webcam."""

    def __init__(
        self, name: str, capture: VideoCapture, first: NDArray[np.uint8], *, clock: Callable[[], float]
    ) -> None:
        super().__init__(capture, first)
        self._name = name
        self._clock = clock

    def read(self) -> Frame:
        """Wait for the next frame and return it. Raises CameraError when the camera has stopped."""
        pixels = self._next()
        if pixels is None:
            raise CameraError(f"{self._name} has stopped giving pictures: plug it in again and start anew.")
        return Frame(pixels, self._clock())


class VideoFile(_CaptureSource):
    """A video file or a row of pictures."""

    def __init__(
        self, capture: VideoCapture, first: NDArray[np.uint8], *, reopen: Callable[[], VideoCapture] | None
    ) -> None:
        super().__init__(capture, first)
        self._again = reopen  # opens the clip anew for a loop; None plays it once
        self._start = 0.0  # what the file's own time is added to; grows with each round
        self._last: float | None = None

    def read(self) -> Frame | None:
        """Return the next frame, or None at the end."""
        pixels = self._next()
        if pixels is None:
            pixels = self._rewind()
        if pixels is None:
            return None
        self._last = self._timestamp()
        return Frame(pixels, self._last)

    def _timestamp(self) -> float:
        """Return the time of the frame just read: the file's word when plausible, else the last plus 1/fps."""
        said = self._capture.get(cv2.CAP_PROP_POS_MSEC) / 1000
        if self._last is None:
            self._start = -said if math.isfinite(said) else 0.0
            return 0.0
        at = self._start + said
        if math.isfinite(at) and 0 < at - self._last <= MAX_PAUSE_S:
            return at
        return self._last + 1 / self.fps

    def _rewind(self) -> NDArray[np.uint8] | None:
        """Begin again, by opening anew: seeking to the start is not exact in every container."""
        if self._again is None or self._last is None:
            return None
        self._capture.release()
        self._capture = self._again()
        pixels = _read(self._capture)
        said = self._capture.get(cv2.CAP_PROP_POS_MSEC) / 1000
        self._start = self._last + 1 / self.fps - (said if math.isfinite(said) else 0.0)
        return pixels


def open_camera(
    which: int | str,
    /,
    *,
    size: tuple[int, int] = CAMERA_SIZE,
    clock: Callable[[], float] = time.monotonic,
    opener: Opener = open_capture,
) -> Camera:
    """Open a camera by index or by device path. Raises CameraError if it is missing or busy.

    size : width and height to ask for; the camera gives the nearest that it can
    """
    _silence_opencv()
    index = int(which) if isinstance(which, int) or which.isdigit() else None
    name = f"camera {which}"
    device = Path(f"/dev/video{index}" if index is not None else str(which))
    capture = opener(str(which) if index is None else index)
    if capture.isOpened():
        capture.set(cv2.CAP_PROP_FRAME_WIDTH, size[0])
        capture.set(cv2.CAP_PROP_FRAME_HEIGHT, size[1])
        capture.set(cv2.CAP_PROP_BUFFERSIZE, 1)  # the newest frame, not one that has waited
        first = _read(capture)
        if first is not None:
            return Camera(name, capture, first, clock=clock)
    capture.release()
    raise CameraError(_camera_error(name, device))


def open_clip(path: Path | str, /, *, loop: bool = False, opener: Opener = open_capture) -> VideoFile:
    """Open a video file, or pictures named by a pattern as in `frames/%04d.png`. Raises CameraError.

    loop : begin again at the end, timestamps going on
    """
    _silence_opencv()
    name = str(path)
    if "%" not in name and not Path(name).is_file():
        raise CameraError(
            f"there is no file {name}: check the path, or name pictures by a pattern such as frames/%04d.png."
        )
    capture = opener(name)
    first = _read(capture) if capture.isOpened() else None
    if first is None:
        capture.release()
        raise CameraError(f"{name} cannot be played: give a video that OpenCV can decode, as AVI, MP4, MPG or MOV.")
    return VideoFile(capture, first, reopen=(lambda: opener(name)) if loop else None)


def _camera_error(name: str, device: Path) -> str:
    if os.name == "posix" and not device.exists():
        return f"there is no {name}: plug one in, name another, or give a clip instead."
    if os.name == "posix" and not os.access(device, os.R_OK | os.W_OK):
        return f"{name} may not be used by this account: add it to the group that owns {device} (often `video`)."
    return f"{name} gives no picture: close the program that is using it, or name another."


def _read(capture: VideoCapture) -> NDArray[np.uint8] | None:
    """Return the next picture of a capture, or None."""
    try:
        there, pixels = capture.read()
    except cv2.error:
        return None
    return np.asarray(pixels, dtype=np.uint8) if there and pixels is not None else None


def _sane_fps(fps: float) -> float:
    return fps if math.isfinite(fps) and 0 < fps <= MAX_FPS else DEFAULT_FPS


def _sane_count(count: float) -> int | None:
    return int(count) if math.isfinite(count) and 0 < count < 1e9 else None


def _silence_opencv() -> None:
    """Keep OpenCV and FFmpeg, who write past Python, off the terminal: what matters reaches the user as an error."""
    os.environ.setdefault("OPENCV_FFMPEG_LOGLEVEL", "-8")
    cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)
